// A coded landmark through a sensor's own numbers: mosaic, development, localiser.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <vector>

#include "drivers/camera/bayer.h"
#include "pipeline/room_localiser.h"
#include "tests/support/random.h"
#include "tests/support/rendered_truth.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr double kBlack = 64, kLargest = 1023;
constexpr double kRedSees = 0.55, kBlueSees = 0.4;  // of the light, beside green

/// RGGB, 10 bits in 16, of a sensor that has gains of its own, black that is not 0, and noise as it is there.
std::vector<std::uint8_t> measured(const test::ColourExposure& exposure, const test::Sensor& sensor,
                                   std::uint64_t seed) {
  const int width = exposure[0].width_px, height = exposure[0].height_px;
  std::vector<std::uint8_t> words;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t colour = y % 2 == 0 ? (x % 2 == 0 ? 0U : 1U) : (x % 2 == 0 ? 1U : 2U);
      const double light = exposure[colour].at(x, y) * (colour == 0 ? kRedSees : colour == 2 ? kBlueSees : 1);
      const double noise = std::sqrt(sensor.noise_a * light + sensor.noise_b) *
                           test::random_normal(seed, static_cast<std::uint64_t>(y * width + x));
      const auto value =
          static_cast<unsigned>(std::clamp(std::round(kBlack + (light + noise) * (kLargest - kBlack)), 0.0, kLargest));
      words.push_back(static_cast<std::uint8_t>(value & 0xFFU));
      words.push_back(static_cast<std::uint8_t>(value >> 8U));
    }
  return words;
}

double error_m(const Fix& fix, const test::CameraPose& camera) {
  const Eigen::Vector3d p = fix.main().pose().T_landmark_camera.translation_m;
  return (p - Eigen::Vector3d(camera.position_m[0], camera.position_m[1], camera.position_m[2])).norm();
}

TEST(RawColour, ACodeIsReadAndPlacedAsWellAsFromWhatACameraMakesOfIt) {
  const test::Lens lens;
  const CameraModel camera = test::pinhole_of(lens);
  test::Sensor sensor;
  set_noise(sensor, 1.5);
  const test::RoomRenderer renderer(test::hall_with_sheet("KRGBKKRB"), lens, sensor);
  const LandmarkMap map({{11, "KRGBKKRB", place_upright({0, 0, 0}, 0)}, {12, "RRGKBGKB", place_upright({3, 0, 0}, 0)}});
  BayerDeveloper developer({BayerLayout::Packing::kWords, 10, 0, 0}, {kBlack, 1 / kRedSees, 1 / kBlueSees},
                           lens.width_px, lens.height_px);
  std::vector<std::uint8_t> picture(developer.picture_bytes());
  double developed_squares = 0, made_squares = 0;
  for (const double distance_m : {0.9, 2.4}) {
    const test::CameraPose pose =
        test::look_at_landmark({.distance_m = distance_m, .tilt_rad = 0.5, .azimuth_rad = 0.7, .roll_rad = 1.3});
    const test::ColourExposure exposure = renderer.expose([&](double) { return pose; }, {});
    const auto mosaic = measured(exposure, sensor, 7);
    developer.develop(mosaic.data(), 2 * static_cast<std::size_t>(lens.width_px), picture.data());
    Frame frame;
    frame.set_exposure(MonoTime(5s));
    frame.luma = {picture.data(), lens.width_px, lens.height_px, lens.width_px};
    frame.chroma = developer.chroma_of(picture.data());
    RoomLocaliser unit(camera, {.map = map});
    const Fix& fix = unit.process(frame);
    ASSERT_EQ(fix.landmarks.size(), 1U) << distance_m;
    EXPECT_EQ(fix.main().id, 11) << distance_m;
    EXPECT_EQ(fix.reason, Reason::kNone) << distance_m;
    developed_squares += std::pow(error_m(fix, pose) / (distance_m * distance_m), 2);

    const test::ColourPicture made = read_out(exposure, sensor, test::ChromaLayout::k420, 7);
    frame.luma = made.luma.view(), frame.chroma = made.chroma();
    RoomLocaliser other(camera, {.map = map});
    const Fix& beside = other.process(frame);
    ASSERT_EQ(beside.landmarks.size(), 1U) << distance_m;
    made_squares += std::pow(error_m(beside, pose) / (distance_m * distance_m), 2);
  }
  EXPECT_LT(std::sqrt(developed_squares), 1.5 * std::sqrt(made_squares));
  RecordProperty("developed_over_made", std::to_string(std::sqrt(developed_squares / made_squares)));
}

}  // namespace
}  // namespace ninedot
