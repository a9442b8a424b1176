// A colour camera's pattern moves small dots, unless their blur may alternate with it.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "pipeline/localiser.h"
#include "tests/support/rendered_truth.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// Root mean square of where the ring's dots are found, off where they are, but for what all of them have alike. [px]
struct Scatter {
  double squares = 0;
  int count = 0;
  void add(const Fix& fix, const CameraFromLandmark& T_camera_landmark, double fx_px) {
    std::array<Eigen::Vector2d, kRingDotCount> off_px;
    Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
      const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
      const Eigen::Vector2d true_ray = (T_camera_landmark * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized();
      off_px[dot] = fx_px * (fix.main().sighting.dots[dot].ray - true_ray);
      mean_px += off_px[dot] / kRingDotCount;
    }
    for (const Eigen::Vector2d& off : off_px) squares += (off - mean_px).squaredNorm(), count += 2;
  }
  double px() const { return std::sqrt(squares / count); }
};

TEST(ColourPattern, MovesNoDotsWhereAPictureHasColours) {
  const test::Lens lens;
  const CameraModel camera = test::pinhole_of(lens);
  test::Sensor sensor;
  set_noise(sensor, 1.0);
  const test::RoomRenderer renderer(test::hall_with_sheet("KKKKKKKK"), lens, sensor);
  Scatter as_colours, as_grey;
  for (int i = 0; i < 8; ++i) {
    const test::CameraPose pose = test::look_at_landmark(
        {.distance_m = 2.6 + 0.13 * i, .tilt_rad = 0.4, .azimuth_rad = 0.7 + 0.5 * i, .roll_rad = 0.02 * i});
    const test::ColourPicture picture = read_out(renderer.expose([&](double) { return pose; }, {}), sensor,
                                                 test::ChromaLayout::k420, static_cast<std::uint64_t>(i));
    for (const bool has_colours : {true, false}) {
      Frame frame;
      frame.set_exposure(MonoTime(5s));
      frame.luma = picture.luma.view();
      if (has_colours) frame.chroma = picture.chroma();
      Localiser unit(camera, {});
      const Fix& fix = unit.process(frame);
      ASSERT_EQ(fix.landmarks.size(), 1U) << i;
      (has_colours ? as_colours : as_grey).add(fix, test::sheet_before(pose), lens.fx_px);
    }
  }
  EXPECT_GT(as_grey.px(), 0.008) << "the pattern moves nothing: the test shows nothing";
  EXPECT_LT(as_colours.px(), 0.75 * as_grey.px());
  RecordProperty("with_over_without", std::to_string(as_colours.px() / as_grey.px()));
}

}  // namespace
}  // namespace ninedot
