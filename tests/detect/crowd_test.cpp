// A picture that holds more than the search of one frame is allowed to look at: what it is costs no more than that, and
// the landmark in it is found a few frames later.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "detect/detector.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

constexpr int kWidth_px = 640, kHeight_px = 480;

class Canvas {
 public:
  Canvas() : pixels_(std::size_t{kWidth_px} * kHeight_px, 220) {}

  void set(int x, int y, std::uint8_t luma) {
    if (x >= 0 && y >= 0 && x < kWidth_px && y < kHeight_px)
      pixels_[static_cast<std::size_t>(y * kWidth_px + x)] = luma;
  }
  void disc(double x_px, double y_px, double radius_px) {
    for (int y = static_cast<int>(y_px - radius_px); y <= y_px + radius_px; ++y)
      for (int x = static_cast<int>(x_px - radius_px); x <= x_px + radius_px; ++x)
        if (std::hypot(x - x_px, y - y_px) < radius_px) set(x, y, 30);
  }
  void grid(double pitch_px, double radius_px) {
    for (double y = pitch_px; y < kHeight_px; y += pitch_px)
      for (double x = pitch_px; x < kWidth_px; x += pitch_px) disc(x, y, radius_px);
  }
  /// A landmark and the wall around it, its middle at (500, 390).
  void landmark(double distance_m) {
    test::Scene scene;
    scene.camera = test::look_at_landmark({.distance_m = distance_m, .tilt_rad = 0.3});
    test::set_noise(scene.sensor, 1);
    const test::Picture picture = test::render(scene, 1);
    const int half_px = static_cast<int>(0.105 * 720 / distance_m);
    for (int y = -half_px; y <= half_px; ++y)
      for (int x = -half_px; x <= half_px; ++x) set(500 + x, 390 + y, picture.view().at(320 + x, 240 + y));
  }
  ImageView view() const { return {pixels_.data(), kWidth_px, kHeight_px, kWidth_px}; }

 private:
  std::vector<std::uint8_t> pixels_;
};

bool is_it(const Result<std::span<const LandmarkObservation>>& found) {
  if (!found) return false;
  const Eigen::Vector2d at_px = (*found)[0].dots[kCentreDot].centroid_px;
  return std::abs(at_px.x() - 500) < 10 && std::abs(at_px.y() - 390) < 10;
}

/// \return  how many pictures it took; 0: more than `most`
int pictures_until_found(const Canvas& canvas, int most) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  for (int i = 1; i <= most; ++i) {
    WorkBudget budget;
    if (is_it(detector.find_landmarks(canvas.view(), budget))) return i;
    EXPECT_TRUE(budget.is_overdrawn) << "or it would have been found";
  }
  return 0;
}

struct Crowd {
  const char* name;
  void (*draw)(Canvas&);
  double distance_m;
};
class InACrowd : public testing::TestWithParam<Crowd> {};

TEST(Crowd, APictureOfAUsualRoomIsSearchedWhole) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 4, .tilt_rad = 0.3});
  Detector detector(CameraModel{}, LandmarkGeometry{});
  WorkBudget budget;
  ASSERT_TRUE(detector.find_landmarks(test::render(scene, 1).view(), budget).has_value());
  EXPECT_FALSE(budget.is_overdrawn);
  EXPECT_GT(budget.regions, WorkBudget{}.regions / 2);
  EXPECT_GT(budget.guesses, WorkBudget{}.guesses / 2);
}

TEST_P(InACrowd, TheLandmarkIsFoundByAFewPicturesBecauseEachBeginsWhereTheLastOneEnded) {
  const Crowd& crowd = GetParam();
  Canvas canvas;
  crowd.draw(canvas);
  canvas.landmark(crowd.distance_m);
  const int pictures = pictures_until_found(canvas, 8);
  EXPECT_GT(pictures, 1) << "0: not found; 1: this picture tests nothing";
}

INSTANTIATE_TEST_SUITE_P(Detector, InACrowd,
                         testing::Values(Crowd{"more_regions_than_are_measured", [](Canvas& c) { c.grid(9, 2.9); },
                                               2.5},
                                         Crowd{"spots_like_its_dots", [](Canvas& c) { c.grid(13, 4); }, 3.5}),
                         [](const auto& crowd) { return std::string(crowd.param.name); });

}  // namespace
}  // namespace ninedot
