#include "pose/outline_model.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>

// For the pixel with ray m: the sheet point under it is P = F m (projective, F the inverse of [rX rZ t]), its depth z,
// p = z m. rho = |P - C|, e its direction, g = eX rX + eZ rZ. Moving the sheet by dp changes rho by -h . dp, where
// h = g - n (g.m)/(n.m) discards the part along the ray; moving the pixel changes rho by z h . dm. So
//   d = (rho - r) / |grad|,  grad = z N^T h_xy (N: ray per pixel),  dd/d(rotation, translation) = -[(p - t) x h, h] / |grad|.

namespace ninedot {
namespace {

constexpr double kMinBlur_px2 = 0.12;  // a pixel alone has 1/12
constexpr double kMaxBlur_px2 = 25;
constexpr int kMaxOwn = 4;  // unknowns of a group: paper, ink, two slopes
constexpr int kOwn = kUnknowns;           // first column of the group's own unknowns
constexpr int kGrey = kUnknowns + kMaxOwn;  // column of the grey level
constexpr int kColumns = 16;              // padded, so that every row of the sums is whole vectors
static_assert(kGrey < kColumns);

using Row = std::array<float, kColumns>;

/// Sums of products of all columns: everything that a step needs, in one pass. Four rows at a time, so that each sum is
/// loaded and stored once for four pixels; only blocks on and below the diagonal.
class Products {
 public:
  void add(const std::array<Row, 4>& rows) noexcept {
    for (int block = 0; block < kColumns / 4; ++block) {
      for (int i = 4 * block; i < 4 * block + 4; ++i) {
        std::array<cv::v_float32x4, 4> factor;
        for (std::size_t k = 0; k < 4; ++k) factor[k] = cv::v_setall_f32(rows[k][static_cast<std::size_t>(i)]);
        for (int j = 0; j < 4 * block + 4; j += 4) {
          float* to = &sum_[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
          cv::v_float32x4 s = cv::v_load_aligned(to);
          for (std::size_t k = 0; k < 4; ++k) s = cv::v_muladd(factor[k], cv::v_load_aligned(&rows[k][static_cast<std::size_t>(j)]), s);
          cv::v_store_aligned(to, s);
        }
      }
    }
  }
  double operator()(int i, int j) const noexcept {
    return static_cast<double>(sum_[static_cast<std::size_t>(std::max(i, j))][static_cast<std::size_t>(std::min(i, j))]);
  }

 private:
  alignas(16) std::array<Row, kColumns> sum_{};
};

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
  fit.usable = false;
  const std::int32_t count = group.count;
  const int own = group.whole_dot ? 4 : 2;
  fit.degrees_of_freedom = count - own;
  if (fit.degrees_of_freedom < 4) return;
  const DotView v = view_of(pixels, landmark, state.T_camera_landmark, group.dot);

  // Columns: the unknowns' derivatives for contrast 1, the group's own, the grey level less a constant (for precision).
  Products products;
  alignas(16) std::array<Row, 4> rows{};
  const auto first = static_cast<std::size_t>(group.first);
  const auto blur = static_cast<float>(state.blur_px2);
  const auto blur_cos = static_cast<float>(state.blur_cos_px2), blur_sin = static_cast<float>(state.blur_sin_px2);
  const auto offset = static_cast<float>(state.offset_px);
  const float grey = pixels.luma[first];
  for (std::int32_t i = 0; i < count; ++i) {
    const std::size_t at = first + static_cast<std::size_t>(i);
    Row& row = rows[static_cast<std::size_t>(i) % 4];
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
    const float paper = 1 - cover.above;
    row[kOwn] = paper;
    row[kOwn + 1] = cover.above;
    if (own > 2) {
      row[kOwn + 2] = paper * 0.1F * (pixels.x_px[at] - group.centre_x_px);
      row[kOwn + 3] = paper * 0.1F * (pixels.y_px[at] - group.centre_y_px);
    }
    row[kGrey] = pixels.luma[at] - grey;
    if (i % 4 == 3) products.add(rows);
  }
  if (count % 4 != 0) {
    for (std::size_t k = static_cast<std::size_t>(count) % 4; k < 4; ++k) rows[k].fill(0);
    products.add(rows);
  }

  Eigen::Matrix4d BB;
  Eigen::Vector4d By;
  for (int i = 0; i < kMaxOwn; ++i) {
    By(i) = products(kOwn + i, kGrey);
    for (int j = 0; j < kMaxOwn; ++j) BB(i, j) = products(kOwn + i, kOwn + j);
  }
  if (BB(0, 0) < 0.5 || BB(1, 1) < 0.3) return;  // nothing but paper, or nothing but ink, in sight
  // Slopes that the pixels say nothing of stay zero.
  constexpr double kLeast = 1e-3;
  BB(2, 2) += own > 2 ? kLeast : 1;
  BB(3, 3) += own > 2 ? kLeast : 1;
  const Eigen::LDLT<Eigen::Matrix4d> ldlt(BB);
  const Eigen::Vector4d theta = ldlt.solve(By);
  fit.paper_lsb = theta(0) + static_cast<double>(grey);
  fit.contrast_lsb = theta(0) - theta(1);
  fit.squared_residuals = std::max(products(kGrey, kGrey) - By.dot(theta), 0.0);
  fit.usable = std::isfinite(fit.squared_residuals);
  if (!with_normal || !fit.usable) return;

  Eigen::Matrix<double, kUnknowns, kMaxOwn> JB;
  for (int i = 0; i < kUnknowns; ++i) {
    for (int j = 0; j < kMaxOwn; ++j) JB(i, j) = products(i, kOwn + j);
    fit.gradient(i) = products(i, kGrey) - JB.row(i).dot(theta);
    for (int j = 0; j < kUnknowns; ++j) fit.normal(i, j) = products(i, j);
  }
  fit.gradient *= fit.contrast_lsb;
  fit.normal -= JB * ldlt.solve(JB.transpose());
  fit.normal *= fit.contrast_lsb * fit.contrast_lsb;
  fit.shift_information = fit.normal(6, 6);
  fit.usable = fit.shift_information > 0;
  fit.shift_px = fit.usable ? fit.gradient(6) / fit.shift_information : 0;
}

}  // namespace ninedot
