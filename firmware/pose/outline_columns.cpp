#include "pose/outline_columns.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/vector_clones.h"
#include "pose/normal_tail.h"

// For the pixel with ray m the sheet point under it is p = z m, z = 1 / (n.m / n.t); on the sheet it is
// (rX.(p - t), rZ.(p - t)). rho is its distance from the dot's middle C, (eX, eZ) the direction from there. Moving the
// sheet by dp changes rho by -h . dp, where h = g - n k, g = eX rX + eZ rZ, k = (g.m)/(n.m), discards the part along
// the ray; moving the pixel changes rho by z h . dm. With C at (A, B), p - C is z ((rX - A n / n.t).m,
// (rZ - B n / n.t).m), and these brackets are nothing at C's own ray: what is small is computed from what is small. So
//   d = (rho - r) / |grad|,  grad = z N^T h_xy (N: ray per pixel),  dd/d(rotation, translation) = -[(p - t) x h, h] /
//   |grad|.
// Along the sheet's axes (X, n, Z) p - t is (X, 0, Z) and h is (eX, -k, eZ): their product is (k Z, Z eX - X eZ, -k X).
// All is one loop over lanes, free of branches, which the compiler turns into vector instructions.

namespace ninedot {
namespace {

constexpr float kSlopeUnit = 0.1F;  // per px: makes the slopes' columns about as large as the others over a dot's 10 px
constexpr float kLeastVariance_px2 = 0.1F;  // below a pixel's own 1/12 and a bit, an edge is no Gaussian's
// From an outline to a side of the sheet: the band of pixels and what the blur brings into it, of the usual blur and of
// a wider one.
constexpr float kSeenBeyond_px = 5.5F, kSeenBeyondSigmas = 6.5F;
/// What a tone curve moves a dot's outline inwards, into the dark, it moves the sheet's sides outwards, by less the
/// brighter the wall is: 0.25 of it by one half as bright as paper, 0.38 by one of a third, 0.6 by one of a fifth (an
/// sRGB curve, whatever the light). Left out, it moves dots beside the sides towards P9: by 0.01 to 0.03 px where
/// those are two pixels away.
constexpr double kWallShare = 0.25;
/// The same where what ink does beside a wall has a share of its own (kInkByWall): at the middle of the edge the curve
/// is 0.05 of the light's step away from a straight line, which is 0.125 sigmas of the blur.
constexpr double kWallShareAlone = 0.29;
/// An sRGB curve, of which an offset of kToneOffset tells, makes ink darker by this share of what a
/// pixel sees of such a wall. Left out, dots whose blur reaches both are moved towards the wall: by 0.03 px along a
/// motion of 3 px.
constexpr double kInkByWall = 0.22;
constexpr double kDiagonal = 0.5;          // of both coordinates of a unit vector: 30 degrees from either axis
constexpr float kNotAtCentre_m2 = 1e-12F;  // (1 um)^2: keeps the direction at a dot's very middle finite

BlurShape shape_of(double mean_px2, double cos_px2, double sin_px2) noexcept {
  return {static_cast<float>(mean_px2), static_cast<float>(cos_px2), static_cast<float>(sin_px2)};
}

/// The outline's blur in the direction of (x, y) in the picture, of the length sqrt(length2).
struct Blur {
  float sigma_px, per_px;
  float cos2, sin2;  ///< of twice the direction's angle
};
inline Blur blur_along(const BlurShape& shape, float x, float y, float length2) noexcept {
  const float xx = x * x, yy = y * y, per_length2 = 1 / length2;
  const float cos2 = (xx - yy) * per_length2, sin2 = 2 * x * y * per_length2;
  const float wanted = shape.mean_px2 + shape.cos_px2 * cos2 + shape.sin_px2 * sin2;
  const float sigma_px = std::sqrt(wanted > kLeastVariance_px2 ? wanted : kLeastVariance_px2);
  return {sigma_px, 1 / sigma_px, cos2, sin2};
}

/// How the place on the sheet along (ox, oz), seen by the ray (mx, my), changes from pixel to pixel.
struct SideSlope {
  SideSlope(const DotView& v, float ox, float oz, float mx, float my) noexcept
      : depth(1 / (v.inverse_depth.x() * mx + v.inverse_depth.y() * my + v.inverse_depth.z())),
        along_m(ox * ((v.rX.x() * mx + v.rX.y() * my + v.rX.z()) * depth) +
                oz * ((v.rZ.x() * mx + v.rZ.y() * my + v.rZ.z()) * depth)),
        x(ox * v.px_X.x() + oz * v.px_Z.x() - along_m * v.per_height * v.px_n.x()),
        y(ox * v.px_X.y() + oz * v.px_Z.y() - along_m * v.per_height * v.px_n.y()) {}
  float length2() const noexcept { return x * x + y * y; }
  float m_per_px() const noexcept { return depth * std::sqrt(length2()); }

  float depth, along_m;  ///< the place, from the foot of the camera's perpendicular
  float x, y;            ///< its change over the depth [1/px]
};

/// The share of a pixel that lies beyond the side of the sheet towards (ox, oz). Its edge is blurred as an outline of
/// its direction is. \param line_x, line_y  by which it is drawn elsewhere [px]
inline float share_beyond_side(const DotView& v, float ox, float oz, float mx, float my, float line_x,
                               float line_y) noexcept {
  const SideSlope slope(v, ox, oz, mx, my);
  const float length2 = slope.length2(), per_length = 1 / std::sqrt(length2);
  const float past_px = (slope.along_m - (ox * v.origin.x() + oz * v.origin.y()) - v.paper_radius_m) * per_length;
  const float drawn_px = (slope.x * line_x + slope.y * line_y) * per_length;
  const float z =
      (past_px / slope.depth - drawn_px - v.side_offset_px) * blur_along(v.part_blur, slope.x, slope.y, length2).per_px;
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

/// The share that lies beyond the sheet's white, of a sheet that is drawn once for each part of a smear.
inline void fill_beyond(const Pixels& some, const DotView& v, Lanes& beyond) noexcept {
  beyond = Lanes{};
  const float per_part = 1 / v.parts;
  for (float part = 0.5F - 0.5F * v.parts; part < 0.5F * v.parts; ++part) {
    const float line_x = part * v.part_line_px.x(), line_y = part * v.part_line_px.y();
    Lanes on_sheet = some.there;
    for (const Eigen::Vector2f& side : v.beyond)
      for (std::size_t l = 0; l < kLanes; ++l)
        on_sheet[l] *= 1 - share_beyond_side(v, side.x(), side.y(), some.ray_x[l], some.ray_y[l], line_x, line_y);
    for (std::size_t l = 0; l < kLanes; ++l) beyond[l] += per_part * (some.there[l] - on_sheet[l]);
  }
}

/// What the tone curve makes of the shares of ink and of their changes; then how it changes them itself.
template <Asked kAsked>
void bend_tone(const DotView& v, OutlineColumns& columns) noexcept {
  const auto [a, b, c] = v.tone_bend;
  Lanes slope, bend;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float s = columns[kInkColumn][l], at_both = s * (1 - s), by_share = a + s * (b + s * c);
    bend[l] = at_both * by_share;
    slope[l] = 1 + v.tone * ((1 - 2 * s) * by_share + at_both * (b + 2 * c * s));
    columns[kInkColumn][l] = s + v.tone * bend[l];
  }
  if constexpr (kAsked == Asked::kLightOnly) return;
  for (std::size_t unknown = 0; unknown < kToneUnknown; ++unknown)
    for (std::size_t l = 0; l < kLanes; ++l) columns[kStateColumn + unknown][l] *= slope[l];
  if constexpr (kAsked == Asked::kState)
    for (std::size_t l = 0; l < kLanes; ++l) columns[kToneColumn][l] = -bend[l];
}

/// Where a pixel sees ink and wall a tone curve takes more off its grey level than off those of either alone.
template <Asked kAsked>
void darken_by_wall(const DotView& v, OutlineColumns& columns) noexcept {
  if (v.ink_by_wall == 0) return;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float darker = 1 + v.ink_by_wall * columns[kBeyondColumn][l];
    columns[kInkColumn][l] *= darker;
    if constexpr (kAsked != Asked::kLightOnly)
      for (std::size_t unknown = kStateColumn; unknown < kGreyColumn; ++unknown) columns[unknown][l] *= darker;
  }
}

/// How what lies beyond changes along the side: a wall is brighter beside one half of the dot than beside the other
/// where a door frame, a poster or another sheet begins.
inline void fill_beyond_along(const Pixels& some, const DotView& v, OutlineColumns& columns) noexcept {
  const float tx = -v.outward.y(), tz = v.outward.x(), middle_m = tx * v.middle.x() + tz * v.middle.y();
  const float per_radius = kSlopeUnit / v.radius_m;
  for (std::size_t l = 0; l < kLanes; ++l)
    columns[kBeyondAlongColumn][l] = columns[kBeyondColumn][l] * per_radius *
                                     (SideSlope(v, tx, tz, some.ray_x[l], some.ray_y[l]).along_m - middle_m);
}

/// The columns of the group's light, by the share of each pixel that is ink. A slope of the light is one of the paper
/// and, as far as it is lit, of the ink: left out, it moves the dot.
inline void fill_light(const Pixels& some, const OutlineGroup& group, const DotView& v, float first_luma,
                       OutlineColumns& columns) noexcept {
  const float middle_x = group.centre_x_px, middle_y = group.centre_y_px, lit_ink = v.ink_share;
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float ink = columns[kInkColumn][l], paper = some.there[l] - ink;
    const float lit = kSlopeUnit * (paper + lit_ink * ink);
    columns[kGreyColumn][l] = (some.luma[l] - first_luma) * some.there[l];
    columns[kPaperColumn][l] = paper;
    columns[kSlopeXColumn][l] = lit * (some.x_px[l] - middle_x);
    columns[kSlopeYColumn][l] = lit * (some.y_px[l] - middle_y);
  }
}

/// Of a dot that is small beside its blur.
template <Asked kAsked>
void fill_small(const Pixels& some, const BlurredDisc& disc, OutlineColumns& columns) noexcept {
  Lanes share;
  if constexpr (kAsked == Asked::kLightOnly) {
    disc.ink_share(some.ray_x, some.ray_y, share);
  } else {
    Lanes* const by_state = &columns[kStateColumn];
    std::array<Lanes, kMoveColumns> moves;
    std::array<Lanes, kBlurColumns> blur;
    disc.ink_share(some.ray_x, some.ray_y, share, moves, blur);
    for (std::size_t i = 0; i < kMoveColumns; ++i)
      for (std::size_t l = 0; l < kLanes; ++l) by_state[i][l] = moves[i][l] * some.there[l];
    for (std::size_t k = 0; k < kBlurColumns; ++k)
      for (std::size_t l = 0; l < kLanes; ++l) by_state[kMoveColumns + k][l] = blur[k][l] * some.there[l];
  }
  for (std::size_t l = 0; l < kLanes; ++l) columns[kInkColumn][l] = share[l] * some.there[l];
}

/// How the blurred outline of a dot looks from one pixel.
struct Profile {
  /// What more blur across the outline and what more along it do, which reaches over the bend, in units that both
  /// share.
  float across() const noexcept { return straight + met * k2 * (narrowing * narrowing); }
  float over_bend() const noexcept { return k1 * (0.5F + 2.25F * k2); }

  float A, B, eX, eZ;  ///< on the sheet's axes [m], and the direction from the dot's middle [1]
  float along;         ///< by which moves along the ray count [1]
  float per_slope;     ///< 1 / |grad| [px / m]
  Blur blur;
  float k1, k2, narrowing, straight, met;
  float distance;              ///< signed, in units of the blur
  float outward_x, outward_y;  ///< in the picture [1]
};

// A Gaussian blur along the outline reaches over its bend: with the curvature k in units of the blur, the edge is met
// by t^2 k / 2 + t^4 k^3 / 8 earlier at t along the tangent, t normal; of that the mean and the variance count. The
// blur along is taken as that across: what differs of it, of a blur that is wider one way, made tone curves and shadows
// look like a tilt (recordings of a moving camera).
inline Profile profile_at(const DotView& v, float mx, float my) noexcept {
  const float depth = 1 / (v.inverse_depth.x() * mx + v.inverse_depth.y() * my + v.inverse_depth.z());
  const float dx = mx - v.near_ray.x(), dy = my - v.near_ray.y();
  const float x = (v.by_ray_X.x() * dx + v.by_ray_X.y() * dy + v.left_X) * depth;
  const float z = (v.by_ray_Z.x() * dx + v.by_ray_Z.y() * dy + v.left_Z) * depth;
  const float A = v.middle.x() + x, B = v.middle.y() + z;
  const float rho = std::sqrt(x * x + z * z + kNotAtCentre_m2), per_rho = 1 / rho;
  const float eX = x * per_rho, eZ = z * per_rho;
  const float along = (eX * A + eZ * B) * v.per_height;
  // In units of the depth.
  const float gradient_x = eX * v.px_X.x() + eZ * v.px_Z.x() - along * v.px_n.x();
  const float gradient_y = eX * v.px_X.y() + eZ * v.px_Z.y() - along * v.px_n.y();
  const float steep2 = gradient_x * gradient_x + gradient_y * gradient_y;
  const float steep = std::sqrt(steep2), per_slope = 1 / (steep * depth);
  const Blur blur = blur_along(v.blur, gradient_x, gradient_y, steep2);
  const float bent = blur.sigma_px * v.bend * (depth * depth * depth) / (steep2 * steep);
  const float k1 = bent < 1 ? bent : 1, k2 = 0.5F * k1 * k1;
  const float narrowing = 1 / std::sqrt(1 + k2);
  const float straight = ((rho - v.radius_m) * per_slope - v.offset_px) * blur.per_px;
  const float met = straight + k1 * (0.5F + 0.75F * k2);
  const float per_steep = 1 / steep;
  return {A,
          B,
          eX,
          eZ,
          along,
          per_slope,
          blur,
          k1,
          k2,
          narrowing,
          straight,
          met,
          met * narrowing,
          gradient_x * per_steep,
          gradient_y * per_steep};
}

/// From the outline outwards: how far, in sigmas of the blur, and which way, as long as a sigma. [px]
inline void look_outward(const Pixels& some, const DotView& v, Lanes& outside, Lanes& x_px, Lanes& y_px) noexcept {
  for (std::size_t l = 0; l < kLanes; ++l) {
    const Profile p = profile_at(v, some.ray_x[l], some.ray_y[l]);
    outside[l] = p.distance;
    x_px[l] = p.outward_x * p.blur.sigma_px, y_px[l] = p.outward_y * p.blur.sigma_px;
  }
}

/// A shadow's edge, as the group sees it.
struct EdgeView {
  EdgeView(const LightEdge& edge, const OutlineGroup& group, float lit_ink_share) noexcept
      : across_x(static_cast<float>(edge.normal.x())),
        across_y(static_cast<float>(edge.normal.y())),
        middle_x(group.centre_x_px),
        middle_y(group.centre_y_px),
        place_px(static_cast<float>(edge.offset_px -
                                    edge.normal.dot(Eigen::Vector2d(group.centre_x_px, group.centre_y_px)))),
        per_width(static_cast<float>(1 / edge.width_px)),
        lit_ink(lit_ink_share) {
    const double larger_lsb = std::max(std::hypot(edge.paper_lsb, edge.ink_lsb), 1.0);
    paper = static_cast<float>(edge.paper_lsb / larger_lsb), ink = static_cast<float>(edge.ink_lsb / larger_lsb);
    more_contrast = static_cast<float>(edge.more_contrast);
  }
  float across_x, across_y, middle_x, middle_y, place_px, per_width, lit_ink;
  float paper, ink;  ///< of the larger step
  float more_contrast;
};

/// In place of the slopes: the columns of an edge of the light, and of its own place, direction and width. Beyond it an
/// outline that moves changes more, or less.
inline void fill_edge(const Pixels& some, const EdgeView& edge, const DotView& v, bool is_small,
                      OutlineColumns& columns) noexcept {
  Lanes contrast, outside{}, out_x{}, out_y{};
  if (!is_small) look_outward(some, v, outside, out_x, out_y);
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float ink = columns[kInkColumn][l], paper = some.there[l] - ink;
    const float dx = some.x_px[l] - edge.middle_x, dy = some.y_px[l] - edge.middle_y;
    const float u = (edge.across_x * dx + edge.across_y * dy - edge.place_px) * edge.per_width;
    const auto [density, tail] = normal_tail(u);
    const float beyond = u > 0 ? 1 - tail : tail;
    const float same_way = (edge.across_x * out_x[l] + edge.across_y * out_y[l]) * edge.per_width;
    const float both = some.there[l] * ink_beyond(beyond, ink, u, outside[l], density * normal_tail(outside[l]).density,
                                                  same_way < -1  ? -1
                                                  : same_way > 1 ? 1
                                                                 : same_way);
    const float step = density * edge.per_width * (edge.paper * paper + edge.ink * ink);
    contrast[l] = 1 + edge.more_contrast * beyond;
    columns[kBeyondEdgeColumn][l] = beyond * some.there[l] - both + edge.lit_ink * both;
    columns[kInkBeyondEdgeColumn][l] = static_cast<float>(kInkOfItsOwn) * both;
    columns[kEdgePlaceColumn][l] = step;
    columns[kEdgeTurnColumn][l] = kSlopeUnit * step * (edge.across_x * dy - edge.across_y * dx);
    columns[kEdgeWidthColumn][l] = step * u;
  }
  for (std::size_t unknown = v.has_tone ? kToneColumn : kStateColumn; unknown < kGreyColumn; ++unknown)
    for (std::size_t l = 0; l < kLanes; ++l) columns[unknown][l] *= contrast[l];
}

/// Of an outline that is long beside its blur: the profile across it.
template <Asked kAsked>
void fill_profile(const Pixels& some, const DotView& v, OutlineColumns& columns) noexcept {
  constexpr auto kPerLever = static_cast<float>(1 / kLever_m);
  Lanes* const by_state = &columns[kStateColumn];
  for (std::size_t l = 0; l < kLanes; ++l) {
    const Profile p = profile_at(v, some.ray_x[l], some.ray_y[l]);
    const auto [density, tail] = normal_tail(p.distance);
    columns[kInkColumn][l] = (p.distance > 0 ? tail : 1 - tail) * some.there[l];
    if constexpr (kAsked == Asked::kLightOnly) continue;

    const float darker = -density * p.narrowing * p.blur.per_px * some.there[l];  // per px outwards, for contrast 1
    if constexpr (kAsked == Asked::kState) {
      const float per_move = darker * p.per_slope, per_turn = per_move * kPerLever;
      const float X = p.A - v.origin.x(), Z = p.B - v.origin.y(), tilt = p.along * per_turn;
      by_state[0][l] = tilt * Z;
      by_state[1][l] = (Z * p.eX - X * p.eZ) * per_turn;
      by_state[2][l] = -tilt * X;
      by_state[3][l] = p.eX * per_move;
      by_state[4][l] = -p.along * per_move;
      by_state[5][l] = p.eZ * per_move;
      by_state[6][l] = darker;
    } else {
      const float c2 = p.eX * p.eX - p.eZ * p.eZ, s2 = 2 * p.eX * p.eZ;
      by_state[0][l] = darker;
      by_state[1][l] = p.eX * darker;
      by_state[2][l] = p.eZ * darker;
      by_state[3][l] = c2 * darker;
      by_state[4][l] = s2 * darker;
      by_state[5][l] = (c2 * c2 - s2 * s2) * darker;
      by_state[6][l] = 2 * c2 * s2 * darker;
    }
    const float wider = darker * (0.5F * p.blur.per_px) * (p.across() - p.over_bend());  // per px^2
    by_state[7][l] = wider;
    by_state[8][l] = wider * p.blur.cos2;
    by_state[9][l] = wider * p.blur.sin2;
  }
}

/// 1 at even columns or rows of the picture, -1 at odd ones; without a branch.
inline float sign_of_pattern(float place_px) noexcept {
  return static_cast<float>(1 - 2 * (static_cast<std::int32_t>(place_px) & 1));
}

template <Asked kAsked>
void fill(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& dot_view, const BlurredDisc& disc,
          PixelRange range, ColumnBatches& batches) noexcept {
  // A copy: whatever the columns' floats overwrite, it is not these, and the loop can be made of vector instructions
  // (a followed frame takes a seventh less of them).
  const DotView v = dot_view;  // NOLINT(performance-unnecessary-copy-initialization)
  const float first_luma = pixels.luma[static_cast<std::size_t>(group.first)];
  const std::optional<LightEdge>& edge = pixels.light_edges[group.dot];
  for (std::size_t batch = 0; batch * kLanes < range.count; ++batch) {
    const Pixels some(pixels, range.first + batch * kLanes * range.every,
                      std::min(kLanes, range.count - batch * kLanes), range.every);
    if (disc.is_small())
      fill_small<kAsked>(some, disc, batches[batch]);
    else
      fill_profile<kAsked>(some, v, batches[batch]);
    if (v.has_tone) bend_tone<kAsked>(v, batches[batch]);
    if (group.at_paper_edge) {
      fill_beyond(some, v, batches[batch][kBeyondColumn]);
      darken_by_wall<kAsked>(v, batches[batch]);
      if (group.whole_dot && pixels.regards_walls) fill_beyond_along(some, v, batches[batch]);
    } else {
      batches[batch][kBeyondColumn] = Lanes{};
    }
    fill_light(some, group, v, first_luma, batches[batch]);
    if (group.whole_dot && edge)
      fill_edge(some, EdgeView(*edge, group, pixels.lit_ink()), v, disc.is_small(), batches[batch]);
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
  const Eigen::Vector2d C = landmark.centre_m(dot), from_foot = at + C;
  middle = from_foot.cast<float>();
  near_ray = (t + C.x() * X + C.y() * Z).hnormalized().cast<float>();
  const Eigen::Vector3d a_X = X - from_foot.x() / height_m * n, a_Z = Z - from_foot.y() / height_m * n;
  const Eigen::Vector3d near_m = near_ray.cast<double>().homogeneous();
  by_ray_X = a_X.head<2>().cast<float>(), by_ray_Z = a_Z.head<2>().cast<float>();
  left_X = static_cast<float>(a_X.dot(near_m)), left_Z = static_cast<float>(a_Z.dot(near_m));
  const Eigen::Matrix2d& N = pixels.normalised_per_px[dot];
  px_X = (N.transpose() * X.head<2>()).cast<float>();
  px_Z = (N.transpose() * Z.head<2>()).cast<float>();
  px_n = (N.transpose() * n.head<2>()).cast<float>();
  radius_m = static_cast<float>(landmark.radius_m(dot));
  // A square pixel is (det N / height) depth^3 of the sheet: its outline's curvature is that squared over r slope^3.
  bend = static_cast<float>(std::pow(N.determinant() / height_m, 2) / landmark.radius_m(dot));
  paper_radius_m = static_cast<float>(landmark.paper_radius_m());
  blur = shape_of(state.blur_px2, state.blur_cos_px2, state.blur_sin_px2);
  const Smear smear(state);
  part_blur = shape_of(smear.blur_px2, smear.cos_px2, smear.sin_px2);
  parts = static_cast<float>(smear.parts);
  part_line_px = (smear.line_px / static_cast<double>(smear.parts)).cast<float>();
  // Of a dot on a diagonal the square's two sides, once one of them is near enough to be seen in its blur; before, what
  // may cover the corner beside it.
  outward = landmark.centre_m(dot).normalized().cast<float>();
  const float x = outward.x() > 0 ? 1.0F : -1.0F, z = outward.y() > 0 ? 1.0F : -1.0F;
  const auto is_seen = [&](float side_x, float side_z) {
    const SideSlope slope(*this, side_x, side_z, near_ray.x(), near_ray.y());
    const float sigma_px = blur_along(blur, slope.x, slope.y, slope.length2()).sigma_px;
    const float gap_px = static_cast<float>(landmark.white_beside_m(dot)) / slope.m_per_px();
    return gap_px < std::max(kSeenBeyond_px, kSeenBeyondSigmas * sigma_px);
  };
  if (outward.cwiseAbs().minCoeff() > kDiagonal && (is_seen(x, 0) || is_seen(0, z))) {
    (void)beyond.try_push_back({x, 0.0F});
    (void)beyond.try_push_back({0.0F, z});
  } else if (dot != kCentreDot) {
    (void)beyond.try_push_back(outward);
  }
  offset_px = static_cast<float>(state.offset_px);
  // Where the tone has a column of its own the offset is not its doing.
  const double share_of_wall = pixels.has_pattern ? kWallShareAlone : kWallShare;
  side_offset_px = pixels.has_tone ? 0 : static_cast<float>(-share_of_wall * std::min(state.offset_px, 0.0));
  const double curve_px = kToneOffset * std::sqrt(std::max(state.blur_px2, static_cast<double>(kLeastVariance_px2)));
  ink_by_wall =
      !pixels.has_pattern ? 0 : static_cast<float>(kInkByWall * std::clamp(state.offset_px / curve_px, 0.0, 1.0));
  ink_share = pixels.ink_share;
  has_tone = pixels.has_tone;
  tone = static_cast<float>(state.tone);
  tone_bend = pixels.tone_bends[dot];
}

void look_outward(const OutlinePixels& pixels, const DotView& view, PixelRange range, std::span<Lanes> outside,
                  std::span<Lanes> x_px, std::span<Lanes> y_px) noexcept {
  for (std::size_t batch = 0; batch * kLanes < range.count; ++batch)
    look_outward(Pixels(pixels, range.first + batch * kLanes, std::min(kLanes, range.count - batch * kLanes), 1), view,
                 outside[batch], x_px[batch], y_px[batch]);
}

NINEDOT_VECTOR_CLONES
void fill_columns(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& view, const BlurredDisc& disc,
                  PixelRange range, Asked asked, ColumnBatches& batches) noexcept {
  switch (asked) {
    case Asked::kLightOnly:
      return fill<Asked::kLightOnly>(pixels, group, view, disc, range, batches);
    case Asked::kState:
      return fill<Asked::kState>(pixels, group, view, disc, range, batches);
    case Asked::kShape:
      return fill<Asked::kShape>(pixels, group, view, disc, range, batches);
  }
}

// Half of the second derivatives of the grey level, all together and along x less along y, change sign from one column
// or row of the picture to the next.
NINEDOT_VECTOR_CLONES
void fill_pattern_columns(const OutlinePixels& pixels, const DotView& dot_view, const BlurredDisc& disc,
                          PixelRange range, ColumnBatches& batches) noexcept {
  const DotView v = dot_view;  // NOLINT(performance-unnecessary-copy-initialization): as in fill()
  for (std::size_t batch = 0; batch * kLanes < range.count; ++batch) {
    const Pixels some(pixels, range.first + batch * kLanes * range.every,
                      std::min(kLanes, range.count - batch * kLanes), range.every);
    std::array<Lanes, kBlurColumns> by_blur;
    Lanes &wider = by_blur[0], &longer = by_blur[1];
    if (disc.is_small()) {
      disc.ink_by_blur(some.ray_x, some.ray_y, by_blur);
    } else {
      for (std::size_t l = 0; l < kLanes; ++l) {
        const Profile p = profile_at(v, some.ray_x[l], some.ray_y[l]);
        const float darker = -normal_tail(p.distance).density * p.narrowing * (0.5F * p.blur.per_px * p.blur.per_px);
        wider[l] = darker * (p.across() - p.over_bend());
        longer[l] = darker * (p.across() + p.over_bend()) * p.blur.cos2;
      }
    }
    OutlineColumns& columns = batches[batch];
    for (std::size_t l = 0; l < kLanes; ++l) {
      const float column = some.there[l] * sign_of_pattern(some.x_px[l]);
      const float row = some.there[l] * sign_of_pattern(some.y_px[l]);
      columns[0][l] = column * wider[l], columns[1][l] = row * wider[l];
      columns[2][l] = column * longer[l], columns[3][l] = row * longer[l];
    }
  }
}

}  // namespace ninedot
