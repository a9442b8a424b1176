#include "tests/bench/accuracy_rooms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "detect/detector.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/commands/world_rows.h"
#include "tests/bench/accuracy_trials.h"
#include "tests/bench/room_bound.h"
#include "tests/support/renderer_optics.h"
#include "world/landmark_codes.h"

namespace ninedot::bench {
namespace {

using namespace std::chrono_literals;

constexpr double kWrongPlace = 0.1;     // of the distance to the nearest landmark
constexpr double kWrongLandmark = 0.2;  // of the distance to it

/// What an integrator would write for this room and camera.
Config config_of(const RoomWalk& walk, const test::Shutter& shutter, bool is_told) {
  Config config;
  if (is_told) config.camera.row_time_us = 1e6 * shutter.row_time_s;
  for (std::size_t i = 0; i < walk.room().landmarks.size(); ++i) {
    const test::HungLandmark& hung = walk.room().landmarks[i];
    const Eigen::Vector3d place_mm = 1000 * test::place_of(walk.room(), hung);
    const Eigen::Vector3d x0 = test::axes_of(hung.side).col(0);
    MapLandmarkConfig landmark;
    landmark.id = static_cast<int>(i) + 1;
    landmark.code = known_code(landmark.id).value();
    landmark.position_mm = {place_mm.x(), place_mm.y(), place_mm.z()};
    landmark.heading_deg = std::atan2(x0.y(), x0.x()) * 180 / std::numbers::pi;
    config.landmarks.push_back(landmark);
  }
  return config;
}

/// Sums over the frames of a row.
class PlaceScore {
 public:
  /// \param covariance  of the position, along the world's axes
  void add(const Eigen::Vector3d& error_m, const Eigen::Matrix3d& covariance, double bound_m, double nearest_m) {
    ++outcome_.frames;
    if (error_m.norm() > kWrongPlace * nearest_m) {
      ++outcome_.wrong;
      return;
    }
    squares_m2_ += error_m.squaredNorm();
    per_sigma_ += (error_m.array().square() / covariance.diagonal().array()).mean();
    ratios_.push_back(error_m.norm() / bound_m);
  }

  PlaceOutcome outcome() {
    PlaceOutcome result = outcome_;
    if (ratios_.empty()) return result;
    const auto used = static_cast<double>(ratios_.size());
    result.rms_m = std::sqrt(squares_m2_ / used), result.per_sigma = std::sqrt(per_sigma_ / used);
    const auto middle = ratios_.begin() + static_cast<std::ptrdiff_t>(ratios_.size() / 2);
    std::nth_element(ratios_.begin(), middle, ratios_.end());
    result.ratio = *middle;
    return result;
  }

 private:
  PlaceOutcome outcome_;
  double squares_m2_ = 0, per_sigma_ = 0;
  std::vector<double> ratios_;
};

/// One frame's truth.
struct Moment {
  const test::Room& room;
  test::CameraPose camera;
  std::vector<std::size_t> shown;

  Eigen::Vector3d camera_m() const { return Eigen::Vector3d(camera.position_m.data()); }
  /// The camera in the frame of a landmark.
  Eigen::Vector3d before(std::size_t landmark) const {
    const test::HungLandmark& hung = room.landmarks[landmark];
    return test::axes_of(hung.side).transpose() * (camera_m() - test::place_of(room, hung));
  }
  double nearest_m() const {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const std::size_t i : shown) nearest_m = std::min(nearest_m, before(i).norm());
    return nearest_m;
  }
};

class WalkScore {
 public:
  explicit WalkScore(const RoomCondition& condition) {
    test::set_noise(sensor_, condition.noise_at_grey128_lsb);
    exposure_ = std::chrono::nanoseconds(std::llround(1e9 * condition.exposure_s));
    is_told_ = condition.is_told;
  }

  void walk(const RoomWalk& walk, std::uint64_t seed) {
    const test::RoomRenderer renderer(walk.room(), lens_, sensor_);
    const test::Shutter shutter = walk.shutter(lens_);
    const LocaliserOptions options = localiser_options(config_of(walk, shutter, is_told_));
    const auto localiser = make_localiser(camera_of(lens_), options);
    for (int number = 0; number < kRoomFrames; ++number) {
      const double time_s = number / kRoomRate_hz;
      const auto way = [&](double after_s) { return walk.camera_at(time_s + after_s); };
      const auto light = renderer.expose(way, shutter);
      const auto picture = test::read_out(light, sensor_, test::ChromaLayout::k420,
                                          test::random_bits(seed, static_cast<std::uint64_t>(number)));
      Frame frame;
      frame.number = static_cast<std::uint64_t>(number);
      frame.luma = picture.luma.view(), frame.chroma = picture.chroma();
      frame.set_exposure(MonoTime(1s + std::chrono::nanoseconds(std::llround(1e9 * time_s))), exposure_);
      const Fix& fix = localiser->process(frame);
      const test::CameraPose camera = walk.camera_at(time_s);
      const Moment moment{walk.room(), camera, landmarks_shown(walk.room(), lens_, camera)};
      count_landmarks(moment, frame, fix);
      score_places(moment, fix, options.trust.max_ambiguity);
    }
  }

  RoomOutcome outcome() {
    RoomOutcome result = outcome_;
    result.world = world_.outcome(), result.track = track_.outcome();
    result.bound_m = std::sqrt(bounds_m2_ / std::max(1, result.frames));
    return result;
  }

 private:
  void count_landmarks(const Moment& moment, const Frame& frame, const Fix& fix) {
    outcome_.shown += static_cast<int>(moment.shown.size());
    WorkBudget budget;
    const auto seen = detector_.find_all_landmarks(frame.luma, budget);
    for (const std::size_t i : moment.shown) {
      const test::Scene alone = scene_of_landmark(moment.room, moment.room.landmarks[i], lens_, sensor_, moment.camera);
      const Eigen::Vector2d p9_px = test::pixel_of_wall_point(lens_, alone.camera, 0, 0);
      const double ring_px = 0.08 * lens_.fx_px / moment.before(i).norm();
      const auto is_here = [&](const LandmarkObservation& observation) {
        const Eigen::Vector2d middle = observation.H_ray_plane.col(2).hnormalized();
        return (camera_of(lens_).pixel_from_normalised(middle) - p9_px).norm() < ring_px;
      };
      outcome_.found += seen && std::ranges::any_of(*seen, is_here);
      outcome_.identified += std::ranges::any_of(fix.landmarks, [&](const LandmarkFix& landmark) {
        return landmark.id == i + 1 && is_true(moment, landmark);
      });
    }
    for (const LandmarkFix& landmark : fix.landmarks)
      outcome_.wrong += landmark.verdict == Reason::kNone && !is_true(moment, landmark);
  }

  /// Also of landmarks that the picture's border cuts.
  static bool is_true(const Moment& moment, const LandmarkFix& landmark) {
    const Eigen::Vector3d truth_m = moment.before(landmark.id - 1U);
    return (landmark.pose().T_landmark_camera.translation_m - truth_m).norm() < kWrongLandmark * truth_m.norm();
  }

  void score_places(const Moment& moment, const Fix& fix, double max_ambiguity) {
    const auto bound_m = room_bound_m(moment.room, moment.shown, lens_, sensor_, moment.camera);
    if (!bound_m) return;  // too little is shown for any place
    ++outcome_.frames;
    bounds_m2_ += *bound_m * *bound_m;
    if (WorldRows::has_row(WorldRows::Kind::kWorld, fix, max_ambiguity))
      world_.add(fix.world->T_world_camera.translation_m - moment.camera_m(),
                 fix.world->covariance.topLeftCorner<3, 3>(), *bound_m, moment.nearest_m());
    if (WorldRows::has_row(WorldRows::Kind::kTrack, fix, max_ambiguity))
      track_.add(fix.track->motion.T_world_camera.translation_m - moment.camera_m(),
                 fix.track->covariance.topLeftCorner<3, 3>(), *bound_m, moment.nearest_m());
  }

  test::Lens lens_;
  test::Sensor sensor_;
  std::chrono::nanoseconds exposure_{};
  bool is_told_ = true;
  Detector detector_{camera_of(lens_), LandmarkGeometry{}};
  RoomOutcome outcome_;
  PlaceScore world_, track_;
  double bounds_m2_ = 0;
};

}  // namespace

RoomOutcome run_walks(const RoomCondition& condition, std::uint64_t seed) {
  WalkScore score(condition);
  for (int walk = 0; walk < kRoomWalks; ++walk) {
    const std::uint64_t walk_seed = test::random_bits(seed, static_cast<std::uint64_t>(walk));
    score.walk(RoomWalk(condition, test::Random(walk_seed)), walk_seed);
  }
  return score.outcome();
}

}  // namespace ninedot::bench
