#include "pose/outline_columns.h"

#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>

// For the pixel with ray m the sheet point under it is p = z m, z = 1 / (n.m / n.t); on the sheet it is
// (rX.(p - t), rZ.(p - t)). rho is its distance from the dot's middle C, (eX, eZ) the direction from there. Moving the
// sheet by dp changes rho by -h . dp, where h = g - n k, g = eX rX + eZ rZ, k = (g.m)/(n.m), discards the part along
// the ray; moving the pixel changes rho by z h . dm. So
//   d = (rho - r) / |grad|,  grad = z N^T h_xy (N: ray per pixel),  dd/d(rotation, translation) = -[(p - t) x h, h] /
//   |grad|.
// Along the sheet's axes (X, n, Z) p - t is (X, 0, Z) and h is (eX, -k, eZ): their product is (k Z, Z eX - X eZ, -k X).
// All is one loop over lanes, free of branches, which the compiler turns into vector instructions.

namespace ninedot {
namespace {

constexpr float kSlopeUnit = 0.1F;  // per px: makes the slopes' columns about as large as the others over a dot's 10 px
constexpr float kLeastVariance_px2 = 0.1F;  // below a pixel's own 1/12 and a bit, an edge is no Gaussian's
constexpr float kNotAtCentre_m2 = 1e-12F;   // (1 um)^2: keeps the direction at a dot's very middle finite

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

/// The share of a pixel that lies beyond the sheet's white. Its edge is blurred as the outline is, and taken as
/// straight, square to the radius through the dot.
inline float share_beyond(const DotView& v, float mx, float my, float per_sigma) noexcept {
  const float ox = v.outward.x(), oz = v.outward.y();
  const float depth = 1 / (v.inverse_depth.x() * mx + v.inverse_depth.y() * my + v.inverse_depth.z());
  const float A = (v.rX.x() * mx + v.rX.y() * my + v.rX.z()) * depth;
  const float B = (v.rZ.x() * mx + v.rZ.y() * my + v.rZ.z()) * depth;
  const float along = (ox * A + oz * B) * v.per_height;
  const float gradient_x = ox * v.px_X.x() + oz * v.px_Z.x() - along * v.px_n.x();
  const float gradient_y = ox * v.px_X.y() + oz * v.px_Z.y() - along * v.px_n.y();
  const float slope = depth * std::sqrt(gradient_x * gradient_x + gradient_y * gradient_y);
  const float z = ((A - v.origin.x()) * ox + (B - v.origin.y()) * oz - v.paper_radius_m) / slope * per_sigma;
  const float tail = normal_tail(z).tail;
  return z > 0 ? 1 - tail : tail;
}

/// Some pixels of a group as lanes. Unused lanes repeat the first pixel; `there` takes them out.
struct Pixels {
  Pixels(const OutlinePixels& from, std::size_t at, std::size_t used, std::size_t every) noexcept {
    const auto load = [&](const std::vector<float>& column) {
      Lanes lanes;
      if (used == kLanes && every == 1) {
        std::copy_n(&column[at], kLanes, lanes.begin());
      } else {
        lanes.fill(column[at]);
        for (std::size_t l = 1; l < used; ++l) lanes[l] = column[at + l * every];
      }
      return lanes;
    };
    ray_x = load(from.ray_x), ray_y = load(from.ray_y);
    x_px = load(from.x_px), y_px = load(from.y_px);
    luma = load(from.luma);
    for (std::size_t l = 0; l < kLanes; ++l) there[l] = l < used ? 1 : 0;
  }
  Lanes ray_x, ray_y, x_px, y_px, luma, there;
};

template <Asked kAsked>
void fill(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& dot_view, PixelRange range,
          ColumnBatches& batches) noexcept {
  // A copy: whatever the columns' floats overwrite, it is not these, and the loop can be made of vector instructions.
  const DotView v = dot_view;
  const float centre_x_px = group.centre_x_px, centre_y_px = group.centre_y_px;
  constexpr auto kPerLever = static_cast<float>(1 / kLever_m);
  const float first_luma = pixels.luma[static_cast<std::size_t>(group.first)];
  const bool at_paper_edge = group.at_paper_edge;
  for (std::size_t batch = 0; batch * kLanes < range.count; ++batch) {
    const Pixels some(pixels, range.first + batch * kLanes * range.every,
                      std::min(kLanes, range.count - batch * kLanes), range.every);
    OutlineColumns& columns = batches[batch];
    Lanes per_sigma;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const float mx = some.ray_x[l], my = some.ray_y[l];
      const float depth = 1 / (v.inverse_depth.x() * mx + v.inverse_depth.y() * my + v.inverse_depth.z());
      const float A = (v.rX.x() * mx + v.rX.y() * my + v.rX.z()) * depth;
      const float B = (v.rZ.x() * mx + v.rZ.y() * my + v.rZ.z()) * depth;
      const float x = A - v.middle.x(), z = B - v.middle.y();
      const float rho = std::sqrt(x * x + z * z + kNotAtCentre_m2), per_rho = 1 / rho;
      const float eX = x * per_rho, eZ = z * per_rho;
      const float along = (eX * A + eZ * B) * v.per_height;
      // In units of the depth.
      const float gradient_x = eX * v.px_X.x() + eZ * v.px_Z.x() - along * v.px_n.x();
      const float gradient_y = eX * v.px_X.y() + eZ * v.px_Z.y() - along * v.px_n.y();
      const float xx = gradient_x * gradient_x, yy = gradient_y * gradient_y, steep2 = xx + yy, per_steep2 = 1 / steep2;
      const float cos2 = (xx - yy) * per_steep2, sin2 = 2 * gradient_x * gradient_y * per_steep2;
      const float steep = std::sqrt(steep2), per_slope = 1 / (steep * depth);  // slope: |grad| [m / px]

      // How the blurred outline looks here. A Gaussian blur along it reaches over its bend: with the curvature k in
      // units of the blur, the edge is met by t^2 k / 2 + t^4 k^3 / 8 earlier at t along the tangent, t normal; of that
      // the mean and the variance count.
      const float wanted = v.blur_px2 + v.blur_cos_px2 * cos2 + v.blur_sin_px2 * sin2;
      const float sigma_px = std::sqrt(wanted > kLeastVariance_px2 ? wanted : kLeastVariance_px2);
      const float per_px = 1 / sigma_px;
      const float bent = sigma_px * v.bend * (depth * depth * depth) * per_steep2 / steep;
      const float k1 = bent < 1 ? bent : 1, k2 = 0.5F * k1 * k1;
      const float narrowing = 1 / std::sqrt(1 + k2);
      const float straight = ((rho - v.radius_m) * per_slope - v.offset_px) * per_px;
      const float met = straight + k1 * (0.5F + 0.75F * k2);
      const float distance = met * narrowing;  // signed, in units of the blur

      const auto [density, tail] = normal_tail(distance);
      const float ink = (distance > 0 ? tail : 1 - tail) * some.there[l];
      const float paper = some.there[l] - ink;
      columns[kGreyColumn][l] = (some.luma[l] - first_luma) * some.there[l];
      columns[kPaperColumn][l] = paper;
      columns[kInkColumn][l] = ink;
      columns[kSlopeXColumn][l] = paper * (kSlopeUnit * (some.x_px[l] - centre_x_px));
      columns[kSlopeYColumn][l] = paper * (kSlopeUnit * (some.y_px[l] - centre_y_px));
      per_sigma[l] = per_px;
      if constexpr (kAsked == Asked::kLightOnly) continue;

      const float darker = -density * narrowing * per_px * some.there[l];  // per px outwards, for contrast 1
      if constexpr (kAsked == Asked::kState) {
        const float per_move = darker * per_slope, per_turn = per_move * kPerLever;
        const float X = A - v.origin.x(), Z = B - v.origin.y(), tilt = along * per_turn;
        columns[0][l] = tilt * Z;
        columns[1][l] = (Z * eX - X * eZ) * per_turn;
        columns[2][l] = -tilt * X;
        columns[3][l] = eX * per_move;
        columns[4][l] = -along * per_move;
        columns[5][l] = eZ * per_move;
        columns[6][l] = darker;
      } else {
        const float c2 = eX * eX - eZ * eZ, s2 = 2 * eX * eZ;
        columns[0][l] = darker;
        columns[1][l] = eX * darker;
        columns[2][l] = eZ * darker;
        columns[3][l] = c2 * darker;
        columns[4][l] = s2 * darker;
        columns[5][l] = (c2 * c2 - s2 * s2) * darker;
        columns[6][l] = 2 * c2 * s2 * darker;
      }
      const float wider = darker * (0.5F * per_px) *
                          (straight + met * k2 * (narrowing * narrowing) - k1 * (0.5F + 2.25F * k2));  // per px^2
      columns[7][l] = wider;
      columns[8][l] = wider * cos2;
      columns[9][l] = wider * sin2;
    }
    columns[kBeyondColumn] = Lanes{};
    if (!at_paper_edge) continue;
    for (std::size_t l = 0; l < kLanes; ++l)
      columns[kBeyondColumn][l] = share_beyond(v, some.ray_x[l], some.ray_y[l], per_sigma[l]) * some.there[l];
  }
}

}  // namespace

DotView::DotView(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state,
                 std::size_t dot) {
  const CameraFromLandmark& T = state.T_camera_landmark;
  const Eigen::Vector3d X = T.rotation.col(0), Z = T.rotation.col(2), n = T.rotation.col(1), t = T.translation_m;
  const double height_m = n.dot(t);
  rX = X.cast<float>(), rZ = Z.cast<float>();
  inverse_depth = (n / height_m).cast<float>();
  per_height = static_cast<float>(1 / height_m);
  const Eigen::Vector2d at{X.dot(t), Z.dot(t)};
  origin = at.cast<float>();
  middle = (at + landmark.centre_m(dot)).cast<float>();
  const Eigen::Matrix2d& N = pixels.normalised_per_px[dot];
  px_X = (N.transpose() * X.head<2>()).cast<float>();
  px_Z = (N.transpose() * Z.head<2>()).cast<float>();
  px_n = (N.transpose() * n.head<2>()).cast<float>();
  radius_m = static_cast<float>(landmark.radius_m(dot));
  // A square pixel is (det N / height) depth^3 of the sheet: its outline's curvature is that squared over r slope^3.
  bend = static_cast<float>(std::pow(N.determinant() / height_m, 2) / landmark.radius_m(dot));
  outward = landmark.centre_m(dot).normalized().cast<float>();
  paper_radius_m = static_cast<float>(landmark.paper_radius_m());
  blur_px2 = static_cast<float>(state.blur_px2);
  blur_cos_px2 = static_cast<float>(state.blur_cos_px2), blur_sin_px2 = static_cast<float>(state.blur_sin_px2);
  offset_px = static_cast<float>(state.offset_px);
}

void fill_columns(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& view, PixelRange range,
                  Asked asked, ColumnBatches& batches) noexcept {
  switch (asked) {
    case Asked::kLightOnly:
      return fill<Asked::kLightOnly>(pixels, group, view, range, batches);
    case Asked::kState:
      return fill<Asked::kState>(pixels, group, view, range, batches);
    case Asked::kShape:
      return fill<Asked::kShape>(pixels, group, view, range, batches);
  }
}

}  // namespace ninedot
