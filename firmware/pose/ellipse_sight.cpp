#include "pose/ellipse_sight.h"

#include <cmath>
#include <numbers>

namespace ninedot {
namespace {

constexpr int kMinRingDotsWithoutP9 = 5;  // an ellipse has five parameters
constexpr int kMinRingDotsOfLevelI = 6;   // one or two of eight missing

/// Point number `i` of a dot's outline [px].
Eigen::Vector2d contour_point_px(const DotObservation& dot, std::size_t i) noexcept {
  const double t_rad = 2 * std::numbers::pi * static_cast<double>(i) / kContourPoints;
  const double along_px = dot.semi_major_px * std::cos(t_rad), across_px = dot.semi_minor_px * std::sin(t_rad);
  const double c = std::cos(dot.angle_rad), s = std::sin(dot.angle_rad);
  return dot.centroid_px + Eigen::Vector2d(c * along_px - s * across_px, s * along_px + c * across_px);
}

}  // namespace

Result<EllipseSight> make_ellipse_sight(const CameraModel& camera, const LandmarkObservation& seen) noexcept {
  EllipseSight sight;
  int ring_count = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    sight.seen[dot] = seen.dots[dot].seen;
    if (!sight.seen[dot]) continue;
    NINEDOT_TRY(sight.outline_centres[dot], camera.normalised_from_pixel(seen.dots[dot].centroid_px));
    ++sight.seen_count;
    if (dot != kCentreDot) ++ring_count;
  }

  if (!sight.seen[kCentreDot]) {
    if (ring_count < kMinRingDotsWithoutP9)
      return fail(Errc::kPoseDegenerate, "without the centre dot, five ring dots must be visible");
    sight.occlusion = Occlusion::kLevelIII;
    return sight;
  }
  if (ring_count >= kMinRingDotsOfLevelI) {
    sight.occlusion = ring_count == static_cast<int>(kRingDotCount) ? Occlusion::kNone : Occlusion::kLevelI;
    return sight;
  }
  const DotObservation& p9 = seen.dots[kCentreDot];
  if (ring_count < 1) return fail(Errc::kPoseDegenerate, "beside the centre dot, one ring dot must be visible");
  if (!(p9.semi_minor_px > 0 && p9.semi_major_px >= p9.semi_minor_px))
    return fail(Errc::kPoseDegenerate, "the centre dot's outline is not known");
  sight.occlusion = Occlusion::kLevelII;
  for (std::size_t i = 0; i < kContourPoints; ++i) {
    NINEDOT_TRY(sight.contour[i], camera.normalised_from_pixel(contour_point_px(p9, i)));
  }
  return sight;
}

}  // namespace ninedot
