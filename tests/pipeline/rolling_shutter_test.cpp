// A rolling shutter that nobody has told of, or told wrongly.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/room_localiser.h"
#include "tests/pipeline/three_sheets.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/random.h"
#include "tests/support/rendered_truth.h"
#include "tests/support/renderer_optics.h"
#include "tests/support/room_renderer.h"
#include "tests/support/sanitizers.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr double kRate_hz = 35, kRowTime_s = 33e-6;
constexpr int kFrames = 16;
constexpr int kSubExposures = test::kSanitized ? 1 : 4;

/// Three sheets at different heights, and a camera before them that turns to and fro by up to 40 degrees per second.
class Hall {
 public:
  explicit Hall(double row_time_s) : shutter_{0.002, row_time_s, kSubExposures} {
    map_ = test::hang_three_sheets(room_, {-0.55, 0.05, 0.5}, {1.75, 1.0, 1.45});
    set_noise(sensor_, 1.5);
    const test::RoomRenderer renderer(room_, lens_, sensor_);
    for (int number = 0; number < kFrames; ++number)
      pictures_.push_back(
          read_out(renderer.expose([&](double after_s) { return camera_at(number / kRate_hz + after_s); }, shutter_),
                   sensor_, test::ChromaLayout::k420, static_cast<std::uint64_t>(number)));
  }

  static test::CameraPose camera_at(double time_s) {
    const double yaw_rad = 0.22 * std::sin(3.2 * time_s) - 0.1;
    const Eigen::Vector3d ahead(std::cos(yaw_rad), std::sin(yaw_rad), 0.02);
    const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d level;
    level << right, ahead.normalized().cross(right), ahead.normalized();
    const Eigen::Quaterniond q(level);
    return {{1.9, 0.1 + 0.5 * time_s, 1.35}, {q.w(), q.x(), q.y(), q.z()}};
  }

  struct Outcome {
    RowTime row_time;
    int places = 0, beyond_5_sigma = 0;  ///< of the frames from `from` on
    double rms_sigmas = 0;
    int poses = 0, poses_beyond_5_sigma = 0;  ///< of the landmarks, each by itself
  };

  /// \param told  of the row time \param from  frames before are looked at, and not counted
  Outcome look(std::optional<std::chrono::nanoseconds> told, int from) const {
    RoomLocaliser unit(test::pinhole_of(lens_), {.row_time = told, .map = map_});
    return look(unit, from);
  }

  const LandmarkMap& map() const { return map_; }
  CameraModel camera() const { return test::pinhole_of(lens_); }

  Outcome look(RoomLocaliser& unit, int from) const {
    Outcome outcome;
    double squares = 0;
    for (int number = 0; number < kFrames; ++number) {
      Frame frame;
      frame.number = static_cast<std::uint64_t>(number);
      const test::ColourPicture& picture = pictures_[static_cast<std::size_t>(number)];
      frame.luma = picture.luma.view(), frame.chroma = picture.chroma();
      frame.set_exposure(MonoTime(5s + std::chrono::nanoseconds(std::llround(1e9 * number / kRate_hz))), 2ms);
      const test::AllocationGuard guard;
      const Fix& fix = unit.process(frame);
      EXPECT_EQ(guard.allocations(), 0U) << "frame " << number;
      outcome.row_time = fix.row_time;
      for (const LandmarkFix& landmark : fix.landmarks)
        if (number >= from && landmark.verdict == Reason::kNone) count_pose(landmark, number, outcome);
      if (!fix.world || number < from) continue;
      const auto truth = camera_at(number / kRate_hz).position_m;
      const Eigen::Vector3d error_m = fix.world->T_world_camera.translation_m - Eigen::Vector3d(truth.data());
      const Eigen::Array3d sigmas =
          error_m.array() / fix.world->covariance.topLeftCorner<3, 3>().diagonal().array().sqrt();
      ++outcome.places;
      outcome.beyond_5_sigma += (sigmas.abs() > 5).any();
      squares += sigmas.square().mean();
    }
    outcome.rms_sigmas = std::sqrt(squares / std::max(1, outcome.places));
    return outcome;
  }

 private:
  void count_pose(const LandmarkFix& landmark, int number, Outcome& outcome) const {
    const WorldFromLandmark& place = map_.find(landmark.id)->T_world_landmark;
    const auto truth = camera_at(number / kRate_hz).position_m;
    const Eigen::Vector3d camera_m = place.inverse() * Eigen::Vector3d(truth.data());
    const PoseEstimate& pose = landmark.pose();
    EXPECT_EQ(landmark.candidates.list[landmark.chosen].outlines.motion.translation_m_s,
              landmark.row_motion.sheet.translation_m_s)
        << "a pose at the middle row by one motion, which says that it is by another";
    const Eigen::Array3d sigmas = (pose.T_landmark_camera.translation_m - camera_m).array() /
                                  pose.covariance.topLeftCorner<3, 3>().diagonal().array().sqrt();
    ++outcome.poses;
    outcome.poses_beyond_5_sigma += (sigmas.abs() > 5).any();
  }

  test::Lens lens_;
  test::Sensor sensor_;
  test::Room room_;
  test::Shutter shutter_;
  LandmarkMap map_;
  std::vector<test::ColourPicture> pictures_;
};

const Hall& rolling_hall() {
  static const Hall hall(kRowTime_s);
  return hall;
}

TEST(RollingShutter, ThatNobodyToldOfIsFoundOut) {
  const Hall::Outcome outcome = rolling_hall().look(std::nullopt, 1);
  EXPECT_EQ(outcome.row_time.source, RowTimeSource::kSeen);
  EXPECT_NEAR(outcome.row_time.mean_s, kRowTime_s, 3 * outcome.row_time.sigma_s);
  EXPECT_LT(outcome.row_time.sigma_s, 2.5e-6);
  EXPECT_GE(outcome.places, kFrames - 3);
  EXPECT_EQ(outcome.beyond_5_sigma, 0);
  EXPECT_LT(outcome.rms_sigmas, 1.5);
  EXPECT_GT(outcome.poses, 2 * kFrames);
  EXPECT_EQ(outcome.poses_beyond_5_sigma, 0);
}

TEST(RollingShutter, AGlobalOneIsFoundOutAsWell) {
  const Hall::Outcome outcome = Hall(0).look(std::nullopt, 0);
  EXPECT_EQ(outcome.row_time.source, RowTimeSource::kSeen);
  EXPECT_NEAR(outcome.row_time.mean_s, 0, 3 * outcome.row_time.sigma_s);
  EXPECT_EQ(outcome.places, kFrames);
  EXPECT_EQ(outcome.beyond_5_sigma, 0);
}

TEST(RollingShutter, ToldRightlyIsBelieved) {
  const Hall::Outcome outcome = rolling_hall().look(33us, 0);
  EXPECT_EQ(outcome.row_time.source, RowTimeSource::kTold);
  EXPECT_EQ(outcome.row_time.mean_s, kRowTime_s);
  EXPECT_EQ(outcome.row_time.sigma_s, 0);
  EXPECT_EQ(outcome.beyond_5_sigma, 0);
}

TEST(RollingShutter, ToldWronglyIsContradictedAndPosesAreRightThen) {
  for (const auto told : {0us, 65us}) {
    const Hall::Outcome outcome = rolling_hall().look(told, 10);
    EXPECT_EQ(outcome.row_time.source, RowTimeSource::kContradicted) << told.count();
    EXPECT_NEAR(outcome.row_time.mean_s, kRowTime_s, 3 * outcome.row_time.sigma_s) << told.count();
    EXPECT_GE(outcome.places, 5) << told.count() << ": sheets that looked moved are believed again";
    EXPECT_EQ(outcome.beyond_5_sigma, 0) << told.count();
  }
}

/// What they were held against was wrong, perhaps: a sheet that was surveyed badly.
TEST(RollingShutter, WhatPicturesSaidIsForgottenWithTheMapThatTheyWereHeldAgainst) {
  RoomMapHandoff maps;
  RoomLocaliser unit(rolling_hall().camera(), {.row_time = 0us, .map = rolling_hall().map(), .new_maps = &maps});
  EXPECT_EQ(rolling_hall().look(unit, 0).row_time.source, RowTimeSource::kContradicted);
  std::vector<MappedLandmark> mended(rolling_hall().map().landmarks().begin(), rolling_hall().map().landmarks().end());
  for (MappedLandmark& landmark : mended) landmark.T_world_landmark.translation_m.z() += 0.01;
  maps.put(std::make_unique<RoomMap>(LandmarkGeometry{}, LandmarkMap(std::move(mended)), 0.01));
  const std::vector<std::uint8_t> grey(640 * 480, 128);
  Frame frame;
  frame.number = 100;
  frame.luma = {grey.data(), 640, 480, 640};
  frame.set_exposure(MonoTime(7s), 2ms);
  EXPECT_EQ(unit.process(frame).row_time.source, RowTimeSource::kTold);
}

/// Half of what it is: that takes longer to be sure of, and until then it is doubted.
TEST(RollingShutter, ToldHalfOfItIsDoubtedAtLeast) {
  const Hall::Outcome outcome = rolling_hall().look(16us, 10);
  EXPECT_GT(outcome.row_time.sigma_s, 0);
  EXPECT_NEAR(outcome.row_time.mean_s, kRowTime_s, 3 * outcome.row_time.sigma_s);
  EXPECT_GE(outcome.places, 5);
  EXPECT_EQ(outcome.beyond_5_sigma, 0);
}

/// One sheet from near, whose shear is no tilt: its perspective tells the two apart.
TEST(RollingShutter, OneLandmarkAloneContradictsAsWell) {
  test::Room room;
  room.wall = {0.4, 0.1, 0.1, 7};
  const test::HungLandmark hung{test::RoomSide::kHighX, 0, 1.35, test::inks_of_code("KKKKKKKK")};
  room.landmarks.push_back(hung);
  const test::Lens lens;
  test::Sensor sensor;
  set_noise(sensor, 1.5);
  const test::RoomRenderer renderer(room, lens, sensor);
  const auto camera_at = [](double time_s) {
    test::CameraPose pose = Hall::camera_at(time_s);
    pose.position_m = {3.2, 0.08 + 0.1 * time_s, 1.3};
    return pose;
  };
  Localiser unit(test::pinhole_of(lens), {});
  int beyond = 0, after = 0;
  for (int number = 0; number < 2 * kFrames; ++number) {
    const double time_s = number / kRate_hz;
    const auto picture = read_out(renderer.expose([&](double after_s) { return camera_at(time_s + after_s); },
                                                  {0.002, kRowTime_s, kSubExposures}),
                                  sensor, test::ChromaLayout::k420, static_cast<std::uint64_t>(number));
    Frame frame;
    frame.number = static_cast<std::uint64_t>(number);
    frame.luma = picture.luma.view(), frame.chroma = picture.chroma();
    frame.set_exposure(MonoTime(5s + std::chrono::nanoseconds(std::llround(1e9 * time_s))), 2ms);
    const Fix& fix = unit.process(frame);
    if (fix.row_time.source == RowTimeSource::kOpen) {
      EXPECT_EQ(fix.row_time.mean_s, 0) << number << ": it counts as seen by a global shutter";
      continue;
    }
    EXPECT_NEAR(fix.row_time.mean_s, kRowTime_s, 4 * fix.row_time.sigma_s) << number;
    if (fix.landmarks.empty() || fix.main().verdict != Reason::kNone) continue;
    const auto truth = camera_at(time_s).position_m;
    const Eigen::Vector3d camera_m =
        test::axes_of(hung.side).transpose() * (Eigen::Vector3d(truth.data()) - test::place_of(room, hung));
    const PoseEstimate& pose = fix.main().pose();
    const Eigen::Array3d sigmas = (pose.T_landmark_camera.translation_m - camera_m).array() /
                                  pose.covariance.topLeftCorner<3, 3>().diagonal().array().sqrt();
    ++after;
    beyond += (sigmas.abs() > 5).any();
  }
  EXPECT_GT(after, kFrames / 2);
  EXPECT_EQ(beyond, 0);
}

}  // namespace
}  // namespace ninedot
