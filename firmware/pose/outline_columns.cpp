#include "pose/outline_columns.h"

#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>

// For the pixel with ray m: the sheet point under it is P = F m (projective, F the inverse of [rX rZ t]), its depth z,
// p = z m. rho = |P - C|, e its direction, g = eX rX + eZ rZ. Moving the sheet by dp changes rho by -h . dp, where
// h = g - n (g.m)/(n.m) discards the part along the ray; moving the pixel changes rho by z h . dm. So
//   d = (rho - r) / |grad|,  grad = z N^T h_xy (N: ray per pixel),  dd/d(rotation, translation) = -[(p - t) x h, h] /
//   |grad|.
// The functions of one pixel below are inlined into one loop over lanes, free of branches, which the compiler turns
// into vector instructions.

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

/// Where a pixel lies against the outline, on the sheet and in the picture.
struct Place {
  float depth, rho;  ///< [m]
  float hx, hy, hz;  ///< change of rho with a move of the sheet, reversed
  float slope;       ///< |grad| [m / px]
  float slope2;      ///< its square
  float cos2, sin2;  ///< of twice the gradient's direction in the picture
};

inline Place place_of(const DotView& v, float mx, float my) noexcept {
  Place p;
  p.depth = 1 / (v.F(2, 0) * mx + v.F(2, 1) * my + v.F(2, 2));
  const float X = (v.F(0, 0) * mx + v.F(0, 1) * my + v.F(0, 2)) * p.depth - v.C.x();
  const float Z = (v.F(1, 0) * mx + v.F(1, 1) * my + v.F(1, 2)) * p.depth - v.C.y();
  p.rho = std::sqrt(X * X + Z * Z + kNotAtCentre_m2);
  const float eX = X / p.rho, eZ = Z / p.rho;
  const float gx = eX * v.rX.x() + eZ * v.rZ.x(), gy = eX * v.rX.y() + eZ * v.rZ.y(),
              gz = eX * v.rX.z() + eZ * v.rZ.z();
  const float along = (gx * mx + gy * my + gz) / (v.n.x() * mx + v.n.y() * my + v.n.z());
  p.hx = gx - v.n.x() * along, p.hy = gy - v.n.y() * along, p.hz = gz - v.n.z() * along;
  const float gradient_x = p.depth * (v.N(0, 0) * p.hx + v.N(1, 0) * p.hy),
              gradient_y = p.depth * (v.N(0, 1) * p.hx + v.N(1, 1) * p.hy);
  p.slope2 = gradient_x * gradient_x + gradient_y * gradient_y;
  p.slope = std::sqrt(p.slope2);
  p.cos2 = (gradient_x * gradient_x - gradient_y * gradient_y) / p.slope2;
  p.sin2 = 2 * gradient_x * gradient_y / p.slope2;
  return p;
}

/// How the blurred outline looks at a pixel.
struct Edge {
  float sigma_px;
  float z;          ///< signed distance in units of the blur, the outline's bend regarded
  float narrowing;  ///< dz / d(distance in units of the blur)
  float met, k1, k2, straight;
};

/// A Gaussian blur along the outline reaches over its bend: with the curvature k in units of the blur, the edge is met
/// by t^2 k / 2 + t^4 k^3 / 8 earlier at t along the tangent, t normal; of that the mean and the variance count.
inline Edge edge_of(const DotView& v, const Place& p) noexcept {
  Edge e;
  const float wanted = v.blur_px2 + v.blur_cos_px2 * p.cos2 + v.blur_sin_px2 * p.sin2;
  const float variance = wanted > kLeastVariance_px2 ? wanted : kLeastVariance_px2;
  e.sigma_px = std::sqrt(variance);
  const float area = v.det_F * p.depth * p.depth * p.depth * v.det_N;
  const float bent = e.sigma_px * area * area / (v.radius_m * p.slope * p.slope2);
  e.k1 = bent < 1 ? bent : 1;
  e.k2 = 0.5F * e.k1 * e.k1;
  e.narrowing = 1 / std::sqrt(1 + e.k2);
  e.straight = ((p.rho - v.radius_m) / p.slope - v.offset_px) / e.sigma_px;
  e.met = e.straight + e.k1 * (0.5F + 0.75F * e.k2);
  e.z = e.met * e.narrowing;
  return e;
}

/// The share of a pixel that lies beyond the sheet's white. Its edge is blurred as the outline is, and taken as
/// straight, square to the radius through the dot.
inline float share_beyond(const DotView& v, float mx, float my, float per_sigma) noexcept {
  const float ox = v.outward.x(), oz = v.outward.y();
  const float gx = ox * v.rX.x() + oz * v.rZ.x(), gy = ox * v.rX.y() + oz * v.rZ.y(),
              gz = ox * v.rX.z() + oz * v.rZ.z();
  const float depth = 1 / (v.F(2, 0) * mx + v.F(2, 1) * my + v.F(2, 2));
  const float X = (v.F(0, 0) * mx + v.F(0, 1) * my + v.F(0, 2)) * depth;
  const float Z = (v.F(1, 0) * mx + v.F(1, 1) * my + v.F(1, 2)) * depth;
  const float along = (gx * mx + gy * my + gz) / (v.n.x() * mx + v.n.y() * my + v.n.z());
  const float hx = gx - v.n.x() * along, hy = gy - v.n.y() * along;
  const float gradient_x = depth * (v.N(0, 0) * hx + v.N(1, 0) * hy),
              gradient_y = depth * (v.N(0, 1) * hx + v.N(1, 1) * hy);
  const float slope = std::sqrt(gradient_x * gradient_x + gradient_y * gradient_y);
  const float z = (X * ox + Z * oz - v.paper_radius_m) / slope * per_sigma;
  const float tail = normal_tail(z).tail;
  return z > 0 ? 1 - tail : tail;
}

/// Some pixels of a group as lanes. Unused lanes repeat the first pixel; `there` takes them out.
struct Pixels {
  Pixels(const OutlinePixels& from, std::size_t at, std::size_t used) noexcept {
    const auto load = [&](const std::vector<float>& column) {
      Lanes lanes;
      if (used == kLanes) {
        std::copy_n(&column[at], kLanes, lanes.begin());
      } else {
        lanes.fill(column[at]);
        std::copy_n(&column[at], used, lanes.begin());
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

}  // namespace

DotView::DotView(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state,
                 std::size_t dot) {
  const CameraFromLandmark& T = state.T_camera_landmark;
  Eigen::Matrix3d G;
  G << T.rotation.col(0), T.rotation.col(2), T.translation_m;
  const Eigen::Matrix3d sheet_from_ray = G.inverse();
  F = sheet_from_ray.cast<float>();
  det_F = static_cast<float>(sheet_from_ray.determinant());
  rX = G.col(0).cast<float>(), rZ = G.col(1).cast<float>(), t = G.col(2).cast<float>();
  n = T.rotation.col(1).cast<float>();
  N = pixels.normalised_per_px[dot].cast<float>();
  det_N = N.determinant();
  C = landmark.centre_m(dot).cast<float>();
  radius_m = static_cast<float>(landmark.radius_m(dot));
  outward = C.normalized();
  paper_radius_m = static_cast<float>(landmark.paper_radius_m());
  blur_px2 = static_cast<float>(state.blur_px2);
  blur_cos_px2 = static_cast<float>(state.blur_cos_px2), blur_sin_px2 = static_cast<float>(state.blur_sin_px2);
  offset_px = static_cast<float>(state.offset_px);
}

void fill_columns(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& dot_view, std::int32_t begin,
                  std::size_t used, ColumnBatches& batches) noexcept {
  // Copies: whatever the columns' floats overwrite, it is not these, and the loop can be made of vector instructions.
  const DotView view = dot_view;
  const float centre_x_px = group.centre_x_px, centre_y_px = group.centre_y_px;
  constexpr auto kPerLever = static_cast<float>(1 / kLever_m);
  const auto first = static_cast<std::size_t>(group.first);
  const float first_luma = pixels.luma[first];
  const bool at_paper_edge = group.at_paper_edge;
  for (std::size_t batch = 0; batch * kLanes < used; ++batch) {
    const Pixels some(pixels, first + static_cast<std::size_t>(begin) + batch * kLanes,
                      std::min(kLanes, used - batch * kLanes));
    OutlineColumns& columns = batches[batch];
    Lanes per_sigma;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const float mx = some.ray_x[l], my = some.ray_y[l];
      const Place p = place_of(view, mx, my);
      const Edge e = edge_of(view, p);
      const auto [density, tail] = normal_tail(e.z);
      const float ink = (e.z > 0 ? tail : 1 - tail) * some.there[l];
      const float paper = some.there[l] - ink;

      const float brighter = density * e.narrowing / e.sigma_px * some.there[l];  // per px outwards, for contrast 1
      const float per_move = -brighter / p.slope, per_turn = per_move * kPerLever;
      const float ax = p.depth * mx - view.t.x(), ay = p.depth * my - view.t.y(), az = p.depth - view.t.z();
      columns[0][l] = (ay * p.hz - az * p.hy) * per_turn;
      columns[1][l] = (az * p.hx - ax * p.hz) * per_turn;
      columns[2][l] = (ax * p.hy - ay * p.hx) * per_turn;
      columns[3][l] = p.hx * per_move;
      columns[4][l] = p.hy * per_move;
      columns[5][l] = p.hz * per_move;
      columns[6][l] = -brighter;
      const float wider = brighter / (2 * e.sigma_px) *
                          (e.k1 * (0.5F + 2.25F * e.k2) - e.straight -
                           e.met * e.k2 * e.narrowing * e.narrowing);  // per px^2 of variance
      columns[7][l] = wider;
      columns[8][l] = wider * p.cos2;
      columns[9][l] = wider * p.sin2;
      columns[kGreyColumn][l] = (some.luma[l] - first_luma) * some.there[l];
      columns[kPaperColumn][l] = paper;
      columns[kInkColumn][l] = ink;
      columns[kSlopeXColumn][l] = paper * kSlopeUnit * (some.x_px[l] - centre_x_px);
      columns[kSlopeYColumn][l] = paper * kSlopeUnit * (some.y_px[l] - centre_y_px);
      per_sigma[l] = 1 / e.sigma_px;
    }
    columns[kBeyondColumn] = Lanes{};
    if (!at_paper_edge) continue;
    for (std::size_t l = 0; l < kLanes; ++l)
      columns[kBeyondColumn][l] = share_beyond(view, some.ray_x[l], some.ray_y[l], per_sigma[l]) * some.there[l];
  }
}

void turn_to_shape(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& view, std::int32_t begin,
                   std::size_t used, ColumnBatches& batches) noexcept {
  const auto first = static_cast<std::size_t>(group.first) + static_cast<std::size_t>(begin);
  for (std::size_t i = 0; i < used; ++i) {
    const float mx = pixels.ray_x[first + i], my = pixels.ray_y[first + i];
    const float depth = 1 / (view.F(2, 0) * mx + view.F(2, 1) * my + view.F(2, 2));
    const float X = (view.F(0, 0) * mx + view.F(0, 1) * my + view.F(0, 2)) * depth - view.C.x();
    const float Z = (view.F(1, 0) * mx + view.F(1, 1) * my + view.F(1, 2)) * depth - view.C.y();
    const float rho = std::sqrt(X * X + Z * Z + kNotAtCentre_m2);
    const float cos1 = X / rho, sin1 = Z / rho;
    const float cos2 = cos1 * cos1 - sin1 * sin1, sin2 = 2 * cos1 * sin1;
    OutlineColumns& columns = batches[i / kLanes];
    const std::size_t lane = i % kLanes;
    const float out = columns[6][lane];
    const std::array<float, 7> shape{1, cos1, sin1, cos2, sin2, cos2 * cos2 - sin2 * sin2, 2 * cos2 * sin2};
    for (std::size_t c = 0; c < shape.size(); ++c) columns[c][lane] = shape[c] * out;
  }
}

}  // namespace ninedot
