#include "pose/outline_model.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

// For the pixel with ray m: the sheet point under it is P = F m (projective, F the inverse of [rX rZ t]), its depth z,
// p = z m. rho = |P - C|, e its direction, g = eX rX + eZ rZ. Moving the sheet by dp changes rho by -h . dp, where
// h = g - n (g.m)/(n.m) discards the part along the ray; moving the pixel changes rho by z h . dm. So
//   d = (rho - r) / |grad|,  grad = z N^T h_xy (N: ray per pixel),  dd/d(rotation, translation) = -[(p - t) x h, h] / |grad|.

namespace ninedot {
namespace {

constexpr double kMinBlur_px2 = 0.12;  // a pixel alone has 1/12
constexpr double kMaxBlur_px2 = 25;
constexpr int kMaxOwn = 4;             // unknowns of a group: paper, ink, two slopes
constexpr int kColumns = kUnknowns + kMaxOwn;

/// 1 - Phi(z) and its density. Abramowitz & Stegun, "Handbook of Mathematical Functions", 26.2.17: error below 7.5e-8.
struct Normal {
  float above, density;
};
inline Normal normal(float z) noexcept {
  const float a = std::abs(z);
  const float density = 0.39894228F * std::exp(-0.5F * z * z);
  const float k = 1 / (1 + 0.2316419F * a);
  const float tail =
      density * k * (0.319381530F + k * (-0.356563782F + k * (1.781477937F + k * (-1.821255978F + k * 1.330274429F))));
  return {z >= 0 ? tail : 1 - tail, density};
}

/// What all pixels of a dot share.
struct DotView {
  Eigen::Matrix3f F;
  Eigen::Vector3f rX, rZ, n, t;
  Eigen::Matrix2f N;
  Eigen::Vector2f C;
  float radius_m, det_F, det_N;
};

DotView view_of(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const CameraFromLandmark& T, std::size_t dot) noexcept {
  DotView v;
  Eigen::Matrix3d G;
  G << T.rotation.col(0), T.rotation.col(2), T.translation_m;
  const Eigen::Matrix3d F = G.inverse();
  v.F = F.cast<float>();
  v.det_F = static_cast<float>(F.determinant());
  v.rX = G.col(0).cast<float>(), v.rZ = G.col(1).cast<float>(), v.t = G.col(2).cast<float>();
  v.n = T.rotation.col(1).cast<float>();
  v.N = pixels.normalised_per_px[dot].cast<float>();
  v.det_N = v.N.determinant();
  v.C = landmark.centre_m(dot).cast<float>();
  v.radius_m = static_cast<float>(landmark.radius_m(dot));
  return v;
}

}  // namespace

void OutlineState::apply(const UnknownVector& step) noexcept {
  const Eigen::Vector3d rotation_rad = step.head<3>() / kLever_m;
  T_camera_landmark.rotation = exp_so3(rotation_rad) * T_camera_landmark.rotation;
  T_camera_landmark.translation_m += step.segment<3>(3);
  offset_px += step(6);
  blur_px2 = std::clamp(blur_px2 + step(7), kMinBlur_px2, kMaxBlur_px2);
  blur_cos_px2 += step(8);
  blur_sin_px2 += step(9);
  const double harmonic = std::hypot(blur_cos_px2, blur_sin_px2);
  const double most = blur_px2 - 0.8 * kMinBlur_px2;
  if (harmonic > most) blur_cos_px2 *= most / harmonic, blur_sin_px2 *= most / harmonic;
}

void fit_group(const OutlinePixels& pixels, const OutlineGroup& group, const LandmarkGeometry& landmark,
               const OutlineState& state, bool with_normal, GroupFit& fit) noexcept {
  constexpr std::int32_t kMost = 1024;
  fit.usable = false;
  const std::int32_t count = std::min(group.count, kMost);
  const int own = group.whole_dot ? 4 : 2;
  fit.degrees_of_freedom = count - own;
  if (fit.degrees_of_freedom < 4) return;
  const DotView v = view_of(pixels, landmark, state.T_camera_landmark, group.dot);

  // Rows: the unknowns' derivatives for contrast 1, then the group's own columns, then the grey level.
  std::array<std::array<float, kColumns + 2>, kMost> rows;
  Eigen::Matrix4d BB = Eigen::Matrix4d::Zero();
  Eigen::Vector4d By = Eigen::Vector4d::Zero();
  const auto first = static_cast<std::size_t>(group.first);
  const auto blur = static_cast<float>(state.blur_px2);
  const auto blur_cos = static_cast<float>(state.blur_cos_px2), blur_sin = static_cast<float>(state.blur_sin_px2);
  const auto offset = static_cast<float>(state.offset_px);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::size_t at = first + static_cast<std::size_t>(i);
    const Eigen::Vector3f m(pixels.ray_x[at], pixels.ray_y[at], 1);
    const Eigen::Vector3f q = v.F * m;
    const float depth = 1 / q.z();
    const Eigen::Vector2f off = q.head<2>() * depth - v.C;
    const float rho = std::max(off.norm(), 1e-6F);
    const Eigen::Vector2f e = off / rho;
    const Eigen::Vector3f g = e.x() * v.rX + e.y() * v.rZ;
    const Eigen::Vector3f h = g - v.n * (g.dot(m) / v.n.dot(m));
    const Eigen::Vector2f grad = depth * (v.N.transpose() * h.head<2>());
    const float slope = grad.norm();
    const Eigen::Vector2f normal_px = grad / slope;
    const float c2 = normal_px.x() * normal_px.x() - normal_px.y() * normal_px.y();
    const float s2 = 2 * normal_px.x() * normal_px.y();
    const float variance = std::max(blur + blur_cos * c2 + blur_sin * s2, 0.1F);
    const float sigma = std::sqrt(variance);
    // A blurred disc's half-level outline shrinks by s^2 / (2 radius of curvature); inside, no more than at the rim.
    const float area = v.det_F * depth * depth * depth * v.det_N;
    const float bend = std::min(area * area / (std::max(rho, 0.7F * v.radius_m) * slope * slope * slope), 1 / sigma);
    const float d = (rho - v.radius_m) / slope + 0.5F * variance * bend - offset;
    const float z = d / sigma;
    const Normal cover = normal(z);

    auto& row = rows[static_cast<std::size_t>(i)];
    if (with_normal) {
      const float brighter = cover.density / sigma;  // per px outwards, for contrast 1
      const Eigen::Vector3f arm = depth * m - v.t;
      const Eigen::Vector3f turn = arm.cross(h) * (-brighter / (slope * static_cast<float>(kLever_m)));
      const Eigen::Vector3f move = h * (-brighter / slope);
      row[0] = turn.x(), row[1] = turn.y(), row[2] = turn.z();
      row[3] = move.x(), row[4] = move.y(), row[5] = move.z();
      row[6] = -brighter;
      const float wider = -brighter * z / (2 * sigma);  // per px^2 of variance
      row[7] = wider, row[8] = wider * c2, row[9] = wider * s2;
    }
    float* b = row.data() + kUnknowns;
    b[0] = 1 - cover.above;
    b[1] = cover.above;
    b[2] = own > 2 ? (1 - cover.above) * 0.1F * (pixels.x_px[at] - group.centre_x_px) : 0;
    b[3] = own > 2 ? (1 - cover.above) * 0.1F * (pixels.y_px[at] - group.centre_y_px) : 0;
    b[4] = pixels.luma[at];
    const Eigen::Vector4d basis(static_cast<double>(b[0]), static_cast<double>(b[1]), static_cast<double>(b[2]), static_cast<double>(b[3]));
    BB.noalias() += basis * basis.transpose();
    By.noalias() += basis * static_cast<double>(b[4]);
  }
  if (own == 2) BB(2, 2) = BB(3, 3) = 1;
  else BB(2, 2) += 1e-3, BB(3, 3) += 1e-3;
  if (BB(0, 0) < 0.5 || BB(1, 1) < 0.3) return;  // nothing but paper, or nothing but ink, in sight
  const Eigen::LDLT<Eigen::Matrix4d> ldlt(BB);
  const Eigen::Vector4d theta = ldlt.solve(By);
  fit.paper_lsb = theta(0);
  fit.contrast_lsb = theta(0) - theta(1);

  Eigen::Matrix<double, kUnknowns, 4> JB = Eigen::Matrix<double, kUnknowns, 4>::Zero();
  fit.normal.setZero();
  fit.gradient.setZero();
  fit.squared_residuals = 0;
  const auto contrast = static_cast<float>(fit.contrast_lsb);
  const Eigen::Vector4f theta_f = theta.cast<float>();
  Eigen::Matrix<float, kUnknowns, kUnknowns> normal_f = Eigen::Matrix<float, kUnknowns, kUnknowns>::Zero();
  Eigen::Matrix<float, kUnknowns, 1> gradient_f = Eigen::Matrix<float, kUnknowns, 1>::Zero();
  Eigen::Matrix<float, kUnknowns, 4> JB_f = Eigen::Matrix<float, kUnknowns, 4>::Zero();
  float squares = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    const Eigen::Map<const Eigen::Vector4f> basis(row.data() + kUnknowns);
    const float residual = row[kUnknowns + 4] - basis.dot(theta_f);
    squares += residual * residual;
    if (!with_normal) continue;
    const Eigen::Map<const Eigen::Matrix<float, kUnknowns, 1>> J(row.data());
    normal_f.noalias() += J * J.transpose();
    gradient_f.noalias() += J * residual;
    JB_f.noalias() += J * basis.transpose();
  }
  fit.squared_residuals = static_cast<double>(squares);
  fit.usable = std::isfinite(squares);
  if (!with_normal || !fit.usable) return;
  JB = JB_f.cast<double>() * fit.contrast_lsb;
  fit.normal = normal_f.cast<double>() * (fit.contrast_lsb * fit.contrast_lsb) - JB * ldlt.solve(JB.transpose());
  fit.gradient = gradient_f.cast<double>() * static_cast<double>(contrast);
  fit.shift_information = fit.normal(6, 6);
  fit.shift_px = fit.shift_information > 0 ? fit.gradient(6) / fit.shift_information : 0;
  fit.usable = fit.shift_information > 0;
}

}  // namespace ninedot
