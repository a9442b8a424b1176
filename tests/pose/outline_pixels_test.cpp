#include "pose/outline_pixels.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace ninedot {
namespace {

constexpr double kFocal_px = 600;

CameraModel camera() {
  CameraModel lens;
  lens.fx_px = lens.fy_px = kFocal_px;
  return lens;
}

/// Seen straight from in front, so that an outline is a circle.
CameraFromLandmark sheet_at(double distance_m) {
  CameraFromLandmark T;
  T.rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  T.translation_m = {0, 0, distance_m};
  return T;
}

/// From a pixel to the outline of the dot, from outside.
double to_outline_px(const LandmarkGeometry& landmark, const CameraFromLandmark& T, std::size_t dot, float x, float y) {
  const Eigen::Vector2d C = landmark.centre_m(dot);
  const Eigen::Vector2d middle_px =
      camera().pixel_from_normalised((T * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized());
  return (Eigen::Vector2d(x, y) - middle_px).norm() - kFocal_px * landmark.radius_m(dot) / T.translation_m.z();
}

/// At 6 m neighbours on the ring are two blurs apart: what sees both would tell each dot of the other's ink.
TEST(OutlinePixels, NoneOfADistantDotSeesItsNeighboursInk) {
  const CameraModel lens = camera();
  const LandmarkGeometry landmark;
  const RayTable rays(lens);
  const std::vector<std::uint8_t> grey(
      static_cast<std::size_t>(lens.width_px) * static_cast<std::size_t>(lens.height_px), 128);
  const ImageView luma{grey.data(), lens.width_px, lens.height_px, lens.width_px};
  const CameraFromLandmark T = sheet_at(6);
  OutlinePixels pixels(4000);
  collect_outline_pixels(luma, lens, rays, landmark, T, 3.0, 1, {}, {}, pixels);
  ASSERT_EQ(pixels.visible_outlines, 9);
  double nearest_other_px = std::numeric_limits<double>::infinity();
  int beyond_own = 0;
  for (const OutlineGroup& group : pixels.groups)
    for (std::int32_t i = group.first; i < group.first + group.count; ++i) {
      const float x = pixels.x_px[static_cast<std::size_t>(i)], y = pixels.y_px[static_cast<std::size_t>(i)];
      const double own_px = to_outline_px(landmark, T, group.dot, x, y);
      if (own_px > 1) ++beyond_own;
      for (std::size_t other = 0; other < kDotCount; ++other)
        if (other != group.dot)
          nearest_other_px = std::min(nearest_other_px, to_outline_px(landmark, T, other, x, y) - own_px);
    }
  EXPECT_GT(nearest_other_px, -0.1) << "a pixel lies nearer to another dot than to its own";
  EXPECT_GT(beyond_own, 50) << "the paper around them is looked at";
}

}  // namespace
}  // namespace ninedot
