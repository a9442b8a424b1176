#include "pose/outline_pixels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "base/contract.h"

namespace ninedot {
namespace {

constexpr double kWholeDotBelow_px = 7.0;  // semi-minor axis; larger dots are cut into stretches of kSector_px:
constexpr double kSector_px = 12.0;    // in a band of 5 px 60 pixels, enough for two grey levels and a shift of 0.01 px
constexpr double kBlurReach_px = 2.0;  // beyond the band, from where an edge still changes the band's outermost pixels
// A neighbour's blurred ink is a hundredth of its contrast at three quarters of the band: 2.3 sigmas of the blur.
constexpr double kReachOfBand = 0.75;
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

/// Where a row crosses the ellipse |M (x - c)| = factor; false where it does not.
bool row_span(const DotEllipse& e, double y_px, double factor, double& x0, double& x1) noexcept {
  const Eigen::Vector2d a = e.circle_from_px.col(0);
  const Eigen::Vector2d b = e.circle_from_px.col(1) * (y_px - e.centre_px.y());
  const double aa = a.squaredNorm(), ab = a.dot(b);
  const double discriminant = ab * ab - aa * (b.squaredNorm() - factor * factor);
  if (!(discriminant > 0)) return false;
  const double root = std::sqrt(discriminant);
  x0 = e.centre_px.x() + (-ab - root) / aa;
  x1 = e.centre_px.x() + (-ab + root) / aa;
  return true;
}

/// 0 .. 1 once around, growing with the angle of (x, y), though not evenly: within a third of it.
double turn_of(double x, double y) noexcept {
  const double sum = std::abs(x) + std::abs(y);
  const double along = sum > 0 ? y / sum : 0;
  return x < 0 ? 0.5 - 0.25 * along : along < 0 ? 1 + 0.25 * along : 0.25 * along;
}

}  // namespace

OutlinePixels::OutlinePixels(std::size_t capacity)
    : x_px(capacity), y_px(capacity), ray_x(capacity), ray_y(capacity), luma(capacity), candidates(capacity) {}

namespace {

/// The other dots whose blurred ink reaches into the band around one.
using Neighbours = InlineVector<const DotEllipse*, kDotCount>;

/// About how far a pixel lies from an outline, outside positive.
double distance_px(const DotEllipse& e, const Eigen::Vector2d& px) noexcept {
  const Eigen::Vector2d q = e.circle_from_px * (px - e.centre_px);
  const double radius = q.norm();
  return radius > 0 ? (radius - 1) * radius / (e.circle_from_px.transpose() * q).norm() : -e.semi_minor_px;
}

/// Whether two outlines may come nearer to each other than `gap_px`.
bool are_close(const DotEllipse& a, const DotEllipse& b, double gap_px) noexcept {
  return (a.centre_px - b.centre_px).norm() < a.semi_major_px + b.semi_major_px + gap_px;
}

/// Whether a pixel sees a neighbour's ink: what it sees of both is no one's outline.
bool sees_another(const Neighbours& neighbours, const DotEllipse& own, const Eigen::Vector2d& px,
                  double reach_px) noexcept {
  for (const DotEllipse* other : neighbours) {
    const double to_other_px = distance_px(*other, px);
    if (to_other_px < reach_px && to_other_px < distance_px(own, px)) return true;
  }
  return false;
}

/// Appends one dot's pixels, sorted into its sectors. \return false when they do not fit
bool append_dot(const ImageView& luma, const RayTable& rays, const DotEllipse& e, const Neighbours& neighbours,
                const RowShift& shift, std::uint8_t dot, double band_px, int thin, bool split, bool at_paper_edge,
                OutlinePixels& out) noexcept {
  const bool small = e.semi_minor_px < kWholeDotBelow_px;
  const bool whole = small && !(split && e.semi_minor_px > kSplitAbove_px);
  const double length_px = std::numbers::pi * (e.semi_major_px + e.semi_minor_px);
  const std::size_t sectors =
      whole   ? 1
      : small ? 8
              : std::clamp<std::size_t>(static_cast<std::size_t>(length_px / kSector_px), 8, kMaxSectors);
  const double outer = 1 + band_px / e.semi_minor_px;
  const double inner = 1 - band_px / e.semi_minor_px;
  const double reach_px = e.semi_major_px * outer + 1;

  std::array<std::int32_t, kMaxSectors> counts{}, next{};
  std::size_t total = 0;
  const int y0 = std::max(0, static_cast<int>(std::ceil(e.centre_px.y() - reach_px)));
  const int y1 = std::min(luma.height_px - 1, static_cast<int>(std::floor(e.centre_px.y() + reach_px)));
  for (int y = y0; y <= y1; ++y) {
    double x0, x1, hole0 = 0, hole1 = -1;
    if (!row_span(e, y, outer, x0, x1)) continue;
    const bool hole = inner > 0 && row_span(e, y, inner, hole0, hole1);
    const int first = std::max(0, static_cast<int>(std::ceil(x0)));
    const int last = std::min(luma.width_px - 1, static_cast<int>(std::floor(x1)));
    for (int x = first; x <= last; ++x) {
      if (hole && x > hole0 && x < hole1) {
        x = static_cast<int>(std::floor(hole1));
        continue;
      }
      if (thin > 1 && (x + 2 * y) % thin != 0) continue;
      if (!neighbours.empty() && sees_another(neighbours, e, {x, y}, kReachOfBand * band_px)) continue;
      std::size_t sector = 0;
      if (!whole) {
        const Eigen::Vector2d q = e.circle_from_px * Eigen::Vector2d(x - e.centre_px.x(), y - e.centre_px.y());
        // Distance to the outline to first order: (|q| - 1) over the length of its gradient, |M^T q| / |q|.
        const double radius2 = q.squaredNorm(), radius = std::sqrt(radius2);
        const double outside = radius2 - radius;
        if (outside * outside > band_px * band_px * (e.circle_from_px.transpose() * q).squaredNorm()) continue;
        sector = std::min(sectors - 1, static_cast<std::size_t>(turn_of(q.x(), q.y()) * static_cast<double>(sectors)));
      }
      if (out.count + total == out.luma.size()) return false;
      out.candidates[total++] = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y),
                                 static_cast<std::uint8_t>(sector)};
      ++counts[sector];
    }
  }
  // Sorted by sector, so that each group is one stretch.
  next[0] = static_cast<std::int32_t>(out.count);
  for (std::size_t s = 1; s < sectors; ++s) next[s] = next[s - 1] + counts[s - 1];
  const auto starts = next;
  for (const OutlinePixels::Candidate& c : std::span(out.candidates).first(total)) {
    float ray_x, ray_y;
    if (!rays.ray(c.x, c.y, ray_x, ray_y)) continue;
    const auto i = static_cast<std::size_t>(next[c.sector]++);
    out.x_px[i] = static_cast<float>(c.x), out.y_px[i] = static_cast<float>(c.y);
    const float rows = static_cast<float>(c.y) - shift.middle_row;
    out.ray_x[i] = ray_x - rows * shift.ray_x, out.ray_y[i] = ray_y - rows * shift.ray_y;
    out.luma[i] = luma.at(c.x, c.y);
  }
  for (std::size_t s = 0; s < sectors; ++s) {
    OutlineGroup group;
    group.first = starts[s];
    group.count = next[s] - starts[s];
    group.dot = dot;
    group.whole_dot = whole;
    group.at_paper_edge = at_paper_edge;
    if (group.count < 8) continue;
    double sum_x = 0, sum_y = 0;
    for (std::int32_t i = group.first; i < next[s]; ++i)
      sum_x += out.x_px[static_cast<std::size_t>(i)], sum_y += out.y_px[static_cast<std::size_t>(i)];
    group.centre_x_px = static_cast<float>(sum_x / group.count);
    group.centre_y_px = static_cast<float>(sum_y / group.count);
    if (!out.groups.try_push_back(group)) return false;
  }
  out.count += total;
  return true;
}

}  // namespace

void collect_outline_pixels(const ImageView& luma, const CameraModel& camera, const RayTable& rays,
                            const LandmarkGeometry& landmark, const CameraFromLandmark& T_camera_landmark,
                            double band_px, int thinning, const std::array<bool, kDotCount>& split,
                            const SheetMotion& motion, OutlinePixels& out) noexcept {
  out.count = 0;
  out.groups.clear();
  out.visible_outlines = 0;
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
    expected += e.semi_minor_px < kWholeDotBelow_px
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
        (void)neighbours.try_push_back(&ellipses[other]);  // as many as dots
    if (!append_dot(luma, rays, ellipses[dot], neighbours, shifts[dot], static_cast<std::uint8_t>(dot), band_px, thin,
                    split[dot], at_paper_edge, out))
      return;
    out.visible_outlines += out.groups.size() > before;
  }
}

}  // namespace ninedot
