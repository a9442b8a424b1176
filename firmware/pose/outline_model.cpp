#include "pose/outline_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>

// For the pixel with ray m: the sheet point under it is P = F m (projective, F the inverse of [rX rZ t]), its depth z,
// p = z m. rho = |P - C|, e its direction, g = eX rX + eZ rZ. Moving the sheet by dp changes rho by -h . dp, where
// h = g - n (g.m)/(n.m) discards the part along the ray; moving the pixel changes rho by z h . dm. So
//   d = (rho - r) / |grad|,  grad = z N^T h_xy (N: ray per pixel),  dd/d(rotation, translation) = -[(p - t) x h, h] /
//   |grad|.

namespace ninedot {
namespace {

constexpr double kMinBlur_px2 = 0.12;  // a pixel alone has 1/12
constexpr double kMaxBlur_px2 = 25;
constexpr int kMaxOwn = 5;  // unknowns of a group: paper, ink, what is beyond the paper, two slopes
// Columns: the unknowns' derivatives for contrast 1, the grey level, the group's own (paper, ink, beyond the paper, two
// slopes), so that a group without the last ones ends earlier.
constexpr int kGrey = kUnknowns;
constexpr int kOwn = kUnknowns + 1;
constexpr int kColumns = kOwn + kMaxOwn;
constexpr std::size_t kPaper = kOwn, kInk = kOwn + 1, kBeyond = kOwn + 2, kSlopeX = kOwn + 3, kSlopeY = kOwn + 4;

constexpr float kSlopeUnit = 0.1F;  // makes the slopes' columns as large as the others

constexpr int kLanes = 8;  // pixels at a time: loops over lanes become vector instructions
using Lanes = std::array<float, kLanes>;
using Batch = std::array<Lanes, kColumns>;

/// Sums of products of all columns: everything that a step needs, in one pass.
class Products {
 public:
  /// Adds the products of the columns [first, end) with each other.
  void add(const Batch& batch, int first, int end) noexcept {
    for (int i = first; i < end; ++i) {
      std::size_t pair = static_cast<std::size_t>(i * (i + 1) / 2 + first);
      const float* a = batch[static_cast<std::size_t>(i)].data();
      const cv::v_float32x4 a0 = cv::v_load_aligned(a), a1 = cv::v_load_aligned(a + 4);
      for (int j = first; j <= i; ++j, ++pair) {
        const float* b = batch[static_cast<std::size_t>(j)].data();
        float* to = sum_[pair].data();
        cv::v_float32x4 s = cv::v_muladd(a0, cv::v_load_aligned(b), cv::v_load_aligned(to));
        s = cv::v_muladd(a1, cv::v_load_aligned(b + 4), s);
        cv::v_store_aligned(to, s);
      }
    }
  }
  /// \param i  at least j
  double operator()(std::size_t i, std::size_t j) const noexcept {
    const auto& s = sum_[i * (i + 1) / 2 + j];
    return static_cast<double>((s[0] + s[1]) + (s[2] + s[3]));
  }

 private:
  alignas(16) std::array<std::array<float, 4>, kColumns*(kColumns + 1) / 2> sum_{};
};

/// exp(x) for x <= 0 without a branch: 2^n times a polynomial on [-ln2/2, ln2/2]; relative error below 3e-7.
/// Coefficients: Cody & Waite's reduction with the Taylor polynomial of degree 6.
inline float exp_of_negative(float x) noexcept {
  x = x > -80.0F ? x : -80.0F;
  const float n = static_cast<float>(static_cast<std::int32_t>(x * 1.44269504F - 0.5F));
  const float r = x - n * 0.693359375F + n * 2.12194440e-4F;
  const float p =
      1 + r * (1 + r * (0.5F + r * (0.166666667F + r * (0.0416666667F + r * (0.00833333333F + r * 0.00138888889F)))));
  const std::int32_t exponent = (static_cast<std::int32_t>(n) + 127) << 23;
  return p * std::bit_cast<float>(exponent);
}

/// The standard normal density and its integral from |z| on.
struct NormalTail {
  float density, tail;
};
/// Abramowitz & Stegun, "Handbook of Mathematical Functions", 26.2.17; error below 7.5e-8.
inline NormalTail normal_tail(float z) noexcept {
  const float density = 0.39894228F * exp_of_negative(-0.5F * z * z);
  const float k = 1 / (1 + 0.2316419F * (z > 0 ? z : -z));
  return {
      density,
      density * k * (0.319381530F + k * (-0.356563782F + k * (1.781477937F + k * (-1.821255978F + k * 1.330274429F))))};
}

/// What all pixels of a dot share.
struct DotView {
  Eigen::Matrix3f F;
  Eigen::Vector3f rX, rZ, n, t;
  Eigen::Matrix2f N;
  Eigen::Vector2f C, outward;
  float radius_m, paper_radius_m, det_F, det_N;
};

DotView view_of(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const CameraFromLandmark& T,
                std::size_t dot) noexcept {
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
  v.outward = v.C.normalized();  // of no use for the centre dot
  v.paper_radius_m = static_cast<float>(landmark.paper_radius_m());
  return v;
}

/// Evaluates up to kLanes pixels of a group into columns; lanes beyond `used` are zero. Plain loops over lanes, free of
/// branches, for the compiler to vectorise. Grey levels are less the group's first one: sums of squares stay small.
void fill_batch(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& v, const OutlineState& state,
                std::int32_t begin, int used, Batch& batch) noexcept {
  const auto first = static_cast<std::size_t>(group.first), at = first + static_cast<std::size_t>(begin);
  // Unused lanes repeat the first pixel; `there` takes them out.
  const auto load = [&](const std::vector<float>& from) {
    Lanes lanes;
    if (used == kLanes) {
      std::copy_n(&from[at], kLanes, lanes.begin());
    } else {
      lanes.fill(from[at]);
      std::copy_n(&from[at], used, lanes.begin());
    }
    return lanes;
  };
  const Lanes ray_x = load(pixels.ray_x), ray_y = load(pixels.ray_y);
  const Lanes x_px = load(pixels.x_px), y_px = load(pixels.y_px);
  const Lanes luma = load(pixels.luma);
  Lanes there, per_sigma;
  for (int l = 0; l < kLanes; ++l) there[static_cast<std::size_t>(l)] = l < used ? 1 : 0;

  const auto blur = static_cast<float>(state.blur_px2);
  const auto blur_cos = static_cast<float>(state.blur_cos_px2), blur_sin = static_cast<float>(state.blur_sin_px2);
  const auto offset = static_cast<float>(state.offset_px);
  constexpr auto kPerLever = static_cast<float>(1 / kLever_m);
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float mx = ray_x[l], my = ray_y[l];
    const float depth = 1 / (v.F(2, 0) * mx + v.F(2, 1) * my + v.F(2, 2));
    const float X = (v.F(0, 0) * mx + v.F(0, 1) * my + v.F(0, 2)) * depth - v.C.x();
    const float Z = (v.F(1, 0) * mx + v.F(1, 1) * my + v.F(1, 2)) * depth - v.C.y();
    const float rho = std::sqrt(X * X + Z * Z + 1e-12F);
    const float eX = X / rho, eZ = Z / rho;
    const float gx = eX * v.rX.x() + eZ * v.rZ.x(), gy = eX * v.rX.y() + eZ * v.rZ.y(),
                gz = eX * v.rX.z() + eZ * v.rZ.z();
    const float along = (gx * mx + gy * my + gz) / (v.n.x() * mx + v.n.y() * my + v.n.z());
    const float hx = gx - v.n.x() * along, hy = gy - v.n.y() * along, hz = gz - v.n.z() * along;
    const float gradient_x = depth * (v.N(0, 0) * hx + v.N(1, 0) * hy),
                gradient_y = depth * (v.N(0, 1) * hx + v.N(1, 1) * hy);
    const float slope2 = gradient_x * gradient_x + gradient_y * gradient_y;
    const float slope = std::sqrt(slope2);
    const float c2 = (gradient_x * gradient_x - gradient_y * gradient_y) / slope2;
    const float s2 = 2 * gradient_x * gradient_y / slope2;
    const float wanted = blur + blur_cos * c2 + blur_sin * s2;
    const float variance = wanted > 0.1F ? wanted : 0.1F;
    const float sigma = std::sqrt(variance);
    // A Gaussian blur along the outline reaches over its bend: with the curvature k in units of the blur, the edge is
    // met by t^2 k / 2 + t^4 k^3 / 8 earlier at t along the tangent, t normal; of that the mean and the variance count.
    const float area = v.det_F * depth * depth * depth * v.det_N;
    const float bent = sigma * area * area / (v.radius_m * slope * slope2);
    const float k1 = bent < 1 ? bent : 1;
    const float k2 = 0.5F * k1 * k1;
    const float narrowing = 1 / std::sqrt(1 + k2);
    const float straight = ((rho - v.radius_m) / slope - offset) / sigma;
    const float met = straight + k1 * (0.5F + 0.75F * k2);
    const float z = met * narrowing;

    const auto [density, tail] = normal_tail(z);
    const float ink = (z > 0 ? tail : 1 - tail) * there[l];
    const float paper = there[l] - ink;

    const float brighter = density * narrowing / sigma * there[l];  // per px outwards, for contrast 1
    const float per_move = -brighter / slope, per_turn = per_move * kPerLever;
    const float ax = depth * mx - v.t.x(), ay = depth * my - v.t.y(), az = depth - v.t.z();
    batch[0][l] = (ay * hz - az * hy) * per_turn;
    batch[1][l] = (az * hx - ax * hz) * per_turn;
    batch[2][l] = (ax * hy - ay * hx) * per_turn;
    batch[3][l] = hx * per_move;
    batch[4][l] = hy * per_move;
    batch[5][l] = hz * per_move;
    batch[6][l] = -brighter;
    const float wider =
        brighter / (2 * sigma) *
        (k1 * (0.5F + 2.25F * k2) - straight - met * k2 * narrowing * narrowing);  // per px^2 of variance
    batch[7][l] = wider;
    batch[8][l] = wider * c2;
    batch[9][l] = wider * s2;
    batch[kGrey][l] = (luma[l] - pixels.luma[first]) * there[l];
    batch[kPaper][l] = paper;
    batch[kInk][l] = ink;
    batch[kSlopeX][l] = paper * kSlopeUnit * (x_px[l] - group.centre_x_px);
    batch[kSlopeY][l] = paper * kSlopeUnit * (y_px[l] - group.centre_y_px);
    per_sigma[l] = 1 / sigma;
  }
  batch[kBeyond] = Lanes{};
  if (!group.at_paper_edge) return;
  // The paper's edge is blurred as the outline is. It is taken as straight, square to the radius through the dot.
  const float ox = v.outward.x(), oz = v.outward.y();
  const float gx = ox * v.rX.x() + oz * v.rZ.x(), gy = ox * v.rX.y() + oz * v.rZ.y(),
              gz = ox * v.rX.z() + oz * v.rZ.z();
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float mx = ray_x[l], my = ray_y[l];
    const float depth = 1 / (v.F(2, 0) * mx + v.F(2, 1) * my + v.F(2, 2));
    const float X = (v.F(0, 0) * mx + v.F(0, 1) * my + v.F(0, 2)) * depth;
    const float Z = (v.F(1, 0) * mx + v.F(1, 1) * my + v.F(1, 2)) * depth;
    const float along = (gx * mx + gy * my + gz) / (v.n.x() * mx + v.n.y() * my + v.n.z());
    const float hx = gx - v.n.x() * along, hy = gy - v.n.y() * along;
    const float gradient_x = depth * (v.N(0, 0) * hx + v.N(1, 0) * hy),
                gradient_y = depth * (v.N(0, 1) * hx + v.N(1, 1) * hy);
    const float slope = std::sqrt(gradient_x * gradient_x + gradient_y * gradient_y);
    const float z = (X * ox + Z * oz - v.paper_radius_m) / slope * per_sigma[l];
    const float tail = normal_tail(z).tail;
    batch[kBeyond][l] = (z > 0 ? 1 - tail : tail) * there[l];
  }
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
  const int own = group.whole_dot ? 5 : group.at_paper_edge ? 3 : 2;
  fit.degrees_of_freedom = count - 2 - (group.whole_dot ? 2 : 0) - (group.at_paper_edge ? 1 : 0);
  if (fit.degrees_of_freedom < 4) return;
  const DotView v = view_of(pixels, landmark, state.T_camera_landmark, group.dot);

  Products products;
  alignas(16) Batch batch{};
  for (std::int32_t i = 0; i < count; i += kLanes) {
    fill_batch(pixels, group, v, state, i, std::min(kLanes, count - i), batch);
    products.add(batch, with_normal ? 0 : kGrey, kOwn + own);
  }

  if (products(kPaper, kPaper) < 0.5 || products(kInk, kInk) < 0.3) return;  // nothing but ink, or paper, in sight

  // Elimination of the group's own unknowns, column by column: what is left among the others is what they say once the
  // group's light is fitted as well as it can be. Only the lower triangle is kept.
  std::array<std::array<double, kColumns>, kColumns> S;
  const auto first = static_cast<std::size_t>(with_normal ? 0 : kGrey), end = static_cast<std::size_t>(kOwn + own);
  for (std::size_t i = first; i < end; ++i)
    for (std::size_t j = first; j <= i; ++j) S[i][j] = products(i, j);
  constexpr double kLeast = 1e-3;  // what the pixels say nothing of stays zero
  for (std::size_t i = kInk + 1; i < end; ++i) S[i][i] += kLeast;
  double ink_lsb = 0, paper_lsb = 0, ink_per_paper = 0;
  for (std::size_t k = end - 1; k >= kPaper; --k) {
    if (!(S[k][k] > 0)) return;
    const double inverse = 1 / S[k][k];
    if (k == kInk) ink_lsb = S[k][kGrey] * inverse, ink_per_paper = S[k][kPaper] * inverse;
    if (k == kPaper) paper_lsb = S[k][kGrey] * inverse;
    for (std::size_t i = first; i < k; ++i) {
      const double factor = S[k][i] * inverse;
      for (std::size_t j = first; j <= i; ++j) S[i][j] -= factor * S[k][j];
    }
  }
  ink_lsb -= ink_per_paper * paper_lsb;
  fit.paper_lsb = paper_lsb + static_cast<double>(pixels.luma[static_cast<std::size_t>(group.first)]);
  fit.contrast_lsb = paper_lsb - ink_lsb;
  fit.squared_residuals = std::max(S[kGrey][kGrey], 0.0);
  fit.usable = std::isfinite(fit.squared_residuals);
  if (!with_normal || !fit.usable) return;

  const double contrast2 = fit.contrast_lsb * fit.contrast_lsb;
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    fit.gradient(row) = S[kGrey][i] * fit.contrast_lsb;
    for (std::size_t j = 0; j <= i; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      fit.normal(row, column) = fit.normal(column, row) = S[i][j] * contrast2;
    }
  }
  fit.shift_information = fit.normal(6, 6);
  fit.usable = fit.shift_information > 0;
  fit.shift_px = fit.usable ? fit.gradient(6) / fit.shift_information : 0;
}

}  // namespace ninedot
