#include "pose/outline_pixels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "base/contract.h"
#include "base/vector_clones.h"

namespace ninedot {
namespace {

// Semi-minor axis; larger dots (of the ring from kWholeDotBelow_px) are cut into stretches of kSector_px. Each has two
// grey levels of its own, which take half of what its pixels say of the outline's place; a whole dot's opposite sides
// share them. P9, of which a part is often all that is in sight of half a landmark, is cut sooner.
constexpr double kWholeCentreBelow_px = 7.0;
constexpr double kSector_px = 12.0;    // in a band of 5 px 60 pixels, enough for two grey levels and a shift of 0.01 px
constexpr double kBlurReach_px = 2.0;  // beyond the band, from where an edge still changes the band's outermost pixels
// A neighbour's blurred ink is a hundredth of its contrast at three quarters of the band: 2.3 sigmas of the blur.
constexpr double kReachOfBand = 0.75;
// Of the work of fitting a pixel: to take it, and times that to ask for each neighbour whether the pixel sees it.
constexpr double kTaking = 1.0 / 14;
constexpr std::size_t kAsking = 2;
constexpr double kSplitAbove_px = 2.0;  // semi-minor axis; an eighth of a smaller outline is less than two pixels

/// One dot's outline in the picture, as an ellipse.
struct DotEllipse {
  Eigen::Vector2d centre_px;
  Eigen::Matrix2d circle_from_px;  // the outline is where |circle_from_px (x - centre)| = 1
  double semi_major_px, semi_minor_px;
};

bool project_dot(const CameraModel& camera, const LandmarkGeometry& landmark, const CameraFromLandmark& T,
                 std::size_t dot, DotEllipse& out, Eigen::Matrix2d& normalised_per_px) noexcept {
  const Eigen::Vector2d C = landmark.centre_m(dot);
  const Eigen::Vector3d p = T * Eigen::Vector3d(C.x(), 0, C.y());
  if (!(p.z() > 1e-3)) return false;
  Eigen::Matrix2d px_per_normalised;
  out.centre_px = camera.pixel_from_normalised(p.hnormalized(), &px_per_normalised);
  Eigen::Matrix2d normalised_per_m;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector3d r = T.rotation.col(axis == 0 ? 0 : 2);
    normalised_per_m.col(axis) = (r.head<2>() - p.hnormalized() * r.z()) / p.z();
  }
  const Eigen::Matrix2d px_per_radius = px_per_normalised * normalised_per_m * landmark.radius_m(dot);
  const double det = px_per_radius.determinant();
  if (!(std::abs(det) > 1e-6) || !px_per_radius.allFinite()) return false;
  out.circle_from_px = px_per_radius.inverse();
  normalised_per_px = px_per_normalised.inverse();
  const double sum = px_per_radius.squaredNorm();
  const double root = std::sqrt(std::max(sum * sum - 4 * det * det, 0.0));
  out.semi_major_px = std::sqrt(0.5 * (sum + root));
  out.semi_minor_px = std::abs(det) / out.semi_major_px;
  return true;
}

/// By how much a dot's rays move from one row to the next, because the sheet moves meanwhile.
struct RowShift {
  float ray_x = 0, ray_y = 0, middle_row = 0;
};

/// A dot appears where the sheet is while its own rows are exposed, and sheared. \param ellipse, normalised_per_px  of
/// the pose; afterwards as it appears, and what a pixel then means as a ray of the pose's instant
RowShift shift_rows(const CameraFromLandmark& T, const Eigen::Vector2d& centre_m, const SheetMotion& motion,
                    DotEllipse& ellipse, Eigen::Matrix2d& normalised_per_px) noexcept {
  const Eigen::Vector3d p = T * Eigen::Vector3d(centre_m.x(), 0, centre_m.y());
  const Eigen::Vector2d ray_per_row = motion.row_time_s * motion.ray_velocity(p, T.translation_m);
  const Eigen::Vector2d px_per_row = normalised_per_px.inverse() * ray_per_row;
  // y' = y + (y' - middle) dy/row
  const double rows = (ellipse.centre_px.y() - motion.middle_row_px) / (1 - px_per_row.y());
  ellipse.centre_px += rows * px_per_row;
  Eigen::Matrix2d straight = Eigen::Matrix2d::Identity();
  straight.col(1) -= px_per_row;
  ellipse.circle_from_px = ellipse.circle_from_px * straight;
  normalised_per_px.col(1) -= ray_per_row;
  return {static_cast<float>(ray_per_row.x()), static_cast<float>(ray_per_row.y()),
          static_cast<float>(motion.middle_row_px)};
}

bool is_small(const DotEllipse& e, std::size_t dot, Cut cut) noexcept {
  return e.semi_minor_px < (dot == kCentreDot && cut != Cut::kWhole ? kWholeCentreBelow_px : kWholeDotBelow_px);
}

/// Where rows cross the ellipses |M (x - c)| = factor. With the columns a, b of M: |a dx + b dy| = factor.
class RowSpans {
 public:
  RowSpans() = default;
  explicit RowSpans(const DotEllipse& e) noexcept : centre_px_(e.centre_px) {
    const Eigen::Vector2d a = e.circle_from_px.col(0), b = e.circle_from_px.col(1);
    aa_ = a.squaredNorm();
    shear_ = -a.dot(b) / aa_;
    const double det = e.circle_from_px.determinant();
    det2_ = det * det;
  }

  /// \return  false where it does not
  bool cross(double y_px, double factor, double& x0, double& x1) const noexcept {
    const double dy = y_px - centre_px_.y();
    const double discriminant = aa_ * factor * factor - det2_ * dy * dy;
    if (!(discriminant > 0)) return false;
    const double half = std::sqrt(discriminant) / aa_, middle = centre_px_.x() + shear_ * dy;
    x0 = middle - half;
    x1 = middle + half;
    return true;
  }

 private:
  Eigen::Vector2d centre_px_{0, 0};
  double aa_ = 1, shear_ = 0, det2_ = 1;
};

/// 0 .. 1 once around, growing with the angle of (x, y), though not evenly: within a third of it.
inline float turn_of(float x, float y) noexcept {
  const float sum = std::abs(x) + std::abs(y);
  const float along = y / (sum > 0 ? sum : 1);
  return x < 0 ? 0.5F - 0.25F * along : along < 0 ? 1 + 0.25F * along : 0.25F * along;
}

// Pixels of a row that are looked at together: about as many as a band of 3 px is long on its sides.
constexpr int kTogether = 8;
using Sectors = std::array<std::int32_t, kTogether>;
constexpr std::int32_t kBesideBand = -1;

/// In which sector of a dot's band pixels lie.
struct SectoredBand {
  SectoredBand(const DotEllipse& e, double band_px, std::size_t sectors)
      : circle_from_px(e.circle_from_px.cast<float>()),
        band2_px2(static_cast<float>(band_px * band_px)),
        count(static_cast<float>(sectors)) {}

  /// Of every `step`-th pixel of a row, the first at (dx, dy) from the dot's centre; kBesideBand: in none. One loop,
  /// free of branches, which the compiler turns into vector instructions.
  Sectors sectors_of(float dx, float dy, int step) const noexcept {
    const Eigen::Matrix2f M = circle_from_px;
    const float stride = static_cast<float>(step), last = count - 1;
    Sectors sectors;
    for (int i = 0; i < kTogether; ++i) {
      const float x = dx + static_cast<float>(i) * stride;
      const float qx = M(0, 0) * x + M(0, 1) * dy, qy = M(1, 0) * x + M(1, 1) * dy;
      // Distance to the outline to first order: (|q| - 1) over the length of its gradient, |M^T q| / |q|.
      const float gx = M(0, 0) * qx + M(1, 0) * qy, gy = M(0, 1) * qx + M(1, 1) * qy;
      const float radius2 = qx * qx + qy * qy, outside = radius2 - std::sqrt(radius2);
      const float turned = turn_of(qx, qy) * count;
      const auto sector = static_cast<std::int32_t>(turned < last ? turned : last);
      sectors[static_cast<std::size_t>(i)] = outside * outside > band2_px2 * (gx * gx + gy * gy) ? kBesideBand : sector;
    }
    return sectors;
  }

  Eigen::Matrix2f circle_from_px;
  float band2_px2, count;
};

}  // namespace

OutlinePixels::OutlinePixels(std::size_t capacity)
    : x_px(capacity),
      y_px(capacity),
      ray_x(capacity),
      ray_y(capacity),
      luma(capacity),
      candidates(capacity),
      ink_of_others_lsb(capacity) {}

namespace {

/// About how far pixels lie from an outline, to first order.
class OutlineGauge {
 public:
  OutlineGauge() = default;
  explicit OutlineGauge(const DotEllipse& e) noexcept
      : centre_px_(e.centre_px),
        metric_(e.circle_from_px.transpose() * e.circle_from_px),
        middle_px_(-e.semi_minor_px) {}
  /// \return  outside positive
  double distance_px(const Eigen::Vector2d& px) const noexcept {
    const Eigen::Vector2d d = px - centre_px_, gradient = metric_ * d;  // of |q|^2 / 2, q on the circle
    const double radius2 = d.dot(gradient);
    return radius2 > 0 ? (radius2 - std::sqrt(radius2)) / gradient.norm() : middle_px_;
  }

 private:
  Eigen::Vector2d centre_px_{0, 0};
  Eigen::Matrix2d metric_ = Eigen::Matrix2d::Identity();
  double middle_px_ = -1;
};

/// Another dot whose blurred ink reaches into the band around one.
struct Neighbour {
  OutlineGauge gauge;
  RowSpans spans;
  double outer = 1;  ///< no pixel beyond so many of its radii sees its ink
};
using Neighbours = InlineVector<Neighbour, kDotCount>;

/// Whether two outlines may come nearer to each other than `gap_px`.
bool are_close(const DotEllipse& a, const DotEllipse& b, double gap_px) noexcept {
  return (a.centre_px - b.centre_px).norm() < a.semi_major_px + b.semi_major_px + gap_px;
}

/// Of one row of the picture: the neighbours that any of its pixels may see, and which ones do.
class NeighboursOfRow {
 public:
  /// \param reach_px  of a neighbour's ink
  NeighboursOfRow(const Neighbours& neighbours, const OutlineGauge& own, int y, double reach_px) noexcept
      : own_(own), y_(y), reach_px_(reach_px) {
    double x0, x1;
    for (const Neighbour& neighbour : neighbours)
      if (neighbour.spans.cross(y, neighbour.outer, x0, x1))
        (void)there_.try_push_back({&neighbour.gauge, x0, x1});  // as many as neighbours
  }

  /// Whether a pixel sees a neighbour's ink: what it sees of both is no one's outline.
  bool seen_from(int x) const noexcept {
    return std::ranges::any_of(there_, [&](const There& other) {
      if (!(other.first_px <= x && x <= other.last_px)) return false;  // most
      const Eigen::Vector2d px(x, y_);
      const double to_other_px = other.gauge->distance_px(px);
      return to_other_px < reach_px_ && to_other_px < own_.distance_px(px);
    });
  }

 private:
  struct There {
    const OutlineGauge* gauge = nullptr;
    double first_px = 0, last_px = 0;
  };
  const OutlineGauge& own_;
  int y_;
  double reach_px_;
  InlineVector<There, kDotCount> there_;
};

/// A dot and how it is to be looked at.
struct DotBand {
  const DotEllipse& e;
  const Neighbours& neighbours;
  RowShift shift;
  double band_px;
  int thin;
  bool whole;
  std::size_t sectors;
};

/// Where each sector's pixels are in OutlinePixels, and the sums of their coordinates.
struct SectorRanges {
  std::array<std::int32_t, kMaxSectors> first{}, end{}, sum_x_px{}, sum_y_px{};
};

/// Calls append(y, first, last) for each stretch of a row that lies in the band, roughly: until it returns false.
/// \return whether it never did
template <typename Append>
bool for_each_stretch(const ImageView& luma, const DotBand& dot, Append&& append) noexcept {
  const DotEllipse& e = dot.e;
  const RowSpans spans(e);
  const double outer = 1 + dot.band_px / e.semi_minor_px;
  const double inner = 1 - dot.band_px / e.semi_minor_px;
  // Of a narrow ellipse the outer one is much too long. Up to 60 degrees of tilt nothing is cut off.
  const double reach_px = std::min(e.semi_major_px * outer + 1, e.semi_major_px + 2 * dot.band_px);
  const int y0 = std::max(0, static_cast<int>(std::ceil(e.centre_px.y() - reach_px)));
  const int y1 = std::min(luma.height_px - 1, static_cast<int>(std::floor(e.centre_px.y() + reach_px)));
  for (int y = y0; y <= y1; ++y) {
    double x0, x1, hole0 = 0, hole1 = 0;
    if (!spans.cross(y, outer, x0, x1)) continue;
    const double dy_px = y - e.centre_px.y(), beside_px = std::sqrt(reach_px * reach_px - dy_px * dy_px);
    x0 = std::max(x0, e.centre_px.x() - beside_px), x1 = std::min(x1, e.centre_px.x() + beside_px);
    const int first = std::max(0, static_cast<int>(std::ceil(x0)));
    const int last = std::min(luma.width_px - 1, static_cast<int>(std::floor(x1)));
    if (inner > 0 && spans.cross(y, inner, hole0, hole1)) {
      const int before = std::min(last, static_cast<int>(std::floor(hole0)));
      if (before >= first && !append(y, first, before)) return false;
      const int after = std::max({first, before + 1, static_cast<int>(std::floor(hole1)) + 1});
      if (after <= last && !append(y, after, last)) return false;
    } else if (first <= last && !append(y, first, last)) {
      return false;
    }
  }
  return true;
}

/// Appends the pixels of a dot that is one group, stretch by stretch. \return false when they do not fit
bool append_rows(const ImageView& luma, const RayTable& rays, const DotBand& dot, OutlinePixels& out,
                 SectorRanges& ranges) noexcept {
  std::size_t at = out.count;
  const bool fits = for_each_stretch(luma, dot, [&](int y, int first, int last) {
    const auto count = static_cast<std::size_t>(last - first) + 1;
    if (count > out.luma.size() - at) return false;
    float *const x_px = &out.x_px[at], *const ray_x = &out.ray_x[at], *const ray_y = &out.ray_y[at];
    rays.rays_of_row(first, y, count, ray_x, ray_y);
    const float rows = static_cast<float>(y) - dot.shift.middle_row;
    const float shift_x = rows * dot.shift.ray_x, shift_y = rows * dot.shift.ray_y;
    const std::uint8_t* const grey = luma.row(y) + first;
    for (std::size_t i = 0; i < count; ++i) {
      x_px[i] = static_cast<float>(first + static_cast<int>(i));
      ray_x[i] -= shift_x, ray_y[i] -= shift_y;
      out.luma[at + i] = grey[i];
    }
    std::fill_n(&out.y_px[at], count, static_cast<float>(y));
    ranges.sum_x_px[0] += (first + last) * (last - first + 1) / 2;
    ranges.sum_y_px[0] += y * (last - first + 1);
    at += count;
    return true;
  });
  ranges.first[0] = static_cast<std::int32_t>(out.count), ranges.end[0] = static_cast<std::int32_t>(at);
  return fits;
}

/// Appends a dot's pixels, sorted by sector, so that each group is one stretch. \return false when they do not fit
NINEDOT_VECTOR_CLONES
bool append_sorted(const ImageView& luma, const RayTable& rays, const DotBand& dot, OutlinePixels& out,
                   SectorRanges& ranges) noexcept {
  const DotEllipse& e = dot.e;
  const SectoredBand band(e, dot.band_px, dot.sectors);
  std::array<std::int32_t, kMaxSectors> counts{};
  std::size_t total = 0;
  const std::size_t room = out.luma.size() - out.count;
  const double reach_px = kReachOfBand * dot.band_px;
  const OutlineGauge own(e);
  const bool fits = for_each_stretch(luma, dot, [&](int y, int first, int last) {
    if (room - total < static_cast<std::size_t>((last - first) / dot.thin) + 1) return false;
    const NeighboursOfRow neighbours(dot.neighbours, own, y, reach_px);
    const float dy = static_cast<float>(y - e.centre_px.y());
    const int begin = first + (dot.thin - (first + 2 * y) % dot.thin) % dot.thin;  // where x + 2 y is a multiple
    for (int x = begin; x <= last; x += kTogether * dot.thin) {
      Sectors there{};
      if (!dot.whole) there = band.sectors_of(static_cast<float>(x - e.centre_px.x()), dy, dot.thin);
      for (int i = 0, at = x; i < kTogether && at <= last; ++i, at += dot.thin) {
        const std::int32_t sector = there[static_cast<std::size_t>(i)];
        if (sector == kBesideBand) continue;
        if (neighbours.seen_from(at)) continue;
        out.candidates[total++] = {static_cast<std::int16_t>(at), static_cast<std::int16_t>(y),
                                   static_cast<std::uint8_t>(sector)};
        ++counts[static_cast<std::size_t>(sector)];
      }
    }
    return true;
  });
  if (!fits) return false;
  ranges.first[0] = static_cast<std::int32_t>(out.count);
  for (std::size_t s = 1; s < dot.sectors; ++s) ranges.first[s] = ranges.first[s - 1] + counts[s - 1];
  ranges.end = ranges.first;
  for (const OutlinePixels::Candidate& c : std::span(out.candidates).first(total)) {
    float ray_x, ray_y;
    if (!rays.ray(c.x, c.y, ray_x, ray_y)) continue;
    const auto i = static_cast<std::size_t>(ranges.end[c.sector]++);
    const float y = static_cast<float>(c.y), rows = y - dot.shift.middle_row;
    out.x_px[i] = static_cast<float>(c.x), out.y_px[i] = y;
    out.ray_x[i] = ray_x - rows * dot.shift.ray_x, out.ray_y[i] = ray_y - rows * dot.shift.ray_y;
    out.luma[i] = luma.at(c.x, c.y);
    ranges.sum_x_px[c.sector] += c.x, ranges.sum_y_px[c.sector] += c.y;
  }
  return true;
}

/// Appends one dot's pixels as groups. \return false when they do not fit
bool append_dot(const ImageView& luma, const RayTable& rays, const DotEllipse& e, const Neighbours& neighbours,
                const RowShift& shift, std::uint8_t dot, double band_px, int thin, Cut cut, bool at_paper_edge,
                OutlinePixels& out) noexcept {
  const bool small = is_small(e, dot, cut);
  const bool whole = small && !(cut == Cut::kSectors && e.semi_minor_px > kSplitAbove_px);
  const double length_px = std::numbers::pi * (e.semi_major_px + e.semi_minor_px);
  const std::size_t sectors =
      whole   ? 1
      : small ? 8
              : std::clamp<std::size_t>(static_cast<std::size_t>(length_px / kSector_px), 8, kMaxSectors);
  const DotBand band{e, neighbours, shift, band_px, thin, whole, sectors};
  SectorRanges ranges;
  // Most dots of most pictures: nothing is sorted, nothing left out.
  const bool is_plain = whole && thin == 1 && neighbours.empty() && !rays.has_gaps();
  if (!(is_plain ? append_rows : append_sorted)(luma, rays, band, out, ranges)) return false;
  for (std::size_t s = 0; s < sectors; ++s) {
    OutlineGroup group;
    group.first = ranges.first[s];
    group.count = ranges.end[s] - ranges.first[s];
    group.dot = dot;
    group.whole_dot = whole;
    group.at_paper_edge = at_paper_edge;
    if (group.count < 8) continue;
    group.centre_x_px = static_cast<float>(static_cast<double>(ranges.sum_x_px[s]) / group.count);
    group.centre_y_px = static_cast<float>(static_cast<double>(ranges.sum_y_px[s]) / group.count);
    if (!out.groups.try_push_back(group)) return false;
  }
  const auto collected = static_cast<std::size_t>(ranges.end[sectors - 1]) - out.count;
  out.work_px += static_cast<int>(kTaking * static_cast<double>(collected * (1 + kAsking * neighbours.size())));
  out.count = static_cast<std::size_t>(ranges.end[sectors - 1]);
  return true;
}

}  // namespace

void collect_outline_pixels(const ImageView& luma, const CameraModel& camera, const RayTable& rays,
                            const LandmarkGeometry& landmark, const CameraFromLandmark& T_camera_landmark,
                            double band_px, int thinning, const Cuts& cuts, const SheetMotion& motion,
                            OutlinePixels& out) noexcept {
  out.count = 0;
  out.work_px = 0;
  out.groups.clear();
  out.visible_outlines = 0;
  out.has_pattern = luma.has_pattern;
  std::array<DotEllipse, kDotCount> ellipses;
  std::array<bool, kDotCount> in_front{};
  std::array<RowShift, kDotCount> shifts;
  double expected = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    in_front[dot] = project_dot(camera, landmark, T_camera_landmark, dot, ellipses[dot], out.normalised_per_px[dot]);
    if (!in_front[dot]) continue;
    if (motion.row_time_s != 0)
      shifts[dot] =
          shift_rows(T_camera_landmark, landmark.centre_m(dot), motion, ellipses[dot], out.normalised_per_px[dot]);
    const DotEllipse& e = ellipses[dot];
    expected += is_small(e, dot, cuts[dot])
                    ? std::numbers::pi * (e.semi_major_px + band_px) * (e.semi_minor_px + band_px)
                    : std::numbers::pi * (e.semi_major_px + e.semi_minor_px) * 2 * band_px;
  }
  const int thin = std::max(thinning, 1 + static_cast<int>(1.1 * expected / static_cast<double>(out.luma.size())));
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (!in_front[dot]) continue;
    const std::size_t before = out.groups.size();
    const double white_px = ellipses[dot].semi_minor_px * LandmarkGeometry::kWhite_radii;
    const bool at_paper_edge = dot != kCentreDot && white_px < band_px + kBlurReach_px;
    Neighbours neighbours;
    for (std::size_t other = 0; other < kDotCount; ++other)
      if (other != dot && in_front[other] && are_close(ellipses[dot], ellipses[other], (1 + kReachOfBand) * band_px))
        (void)neighbours.try_push_back(
            {OutlineGauge(ellipses[other]), RowSpans(ellipses[other]),
             1 + kReachOfBand * band_px / ellipses[other].semi_minor_px});  // as many as dots
    if (!append_dot(luma, rays, ellipses[dot], neighbours, shifts[dot], static_cast<std::uint8_t>(dot), band_px, thin,
                    cuts[dot], at_paper_edge, out))
      return;
    out.visible_outlines += out.groups.size() > before;
  }
}

}  // namespace ninedot
