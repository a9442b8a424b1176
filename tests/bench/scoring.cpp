#include "tests/bench/scoring.h"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>

#include "base/mono_time.h"
#include "pipeline/localiser.h"
#include "tests/bench/picture_quality.h"
#include "tests/bench/position_bound.h"
#include "tests/support/process_picture.h"

namespace ninedot::bench {
namespace {

using Pose = Transform<frame::Landmark, frame::Camera>;

/// An estimate further from the truth than this part of the distance is of something else.
constexpr double kMaxRelativeError = 0.2;

Pose reported_pose(const Report& report) {
  const auto& [w, x, y, z] = report.camera_in_landmark.quaternion_wxyz;
  return {Eigen::Quaterniond(w, x, y, z).toRotationMatrix(),
          Eigen::Vector3d(report.camera_in_landmark.position_m.data())};
}

/// The six errors in the order and the frames of the reported covariance (pose/estimate.h).
Eigen::Matrix<double, 6, 1> error_of(const Pose& truth, const Pose& estimate) {
  Eigen::Matrix<double, 6, 1> error;
  error << truth.translation_m - estimate.translation_m, log_so3(estimate.rotation.transpose() * truth.rotation);
  return error;
}

void compare(const Report& report, Shot& shot) {
  const auto error = error_of(shot.truth.T_landmark_camera, reported_pose(report));
  const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> covariance(report.covariance.data());
  shot.found = true;
  shot.position_error_m = error.head<3>().norm();
  shot.rotation_error_rad = error.tail<3>().norm();
  shot.normalised_error_squared = error.dot(covariance.ldlt().solve(error));
}

double bound_of(const CaseFolder& recording, const CaseFrame& picture, const TruePose& truth) {
  const LandmarkGeometry landmark;
  const auto quality = measure_quality(recording.view(picture), recording.camera, landmark, truth.T_landmark_camera);
  return quality ? position_bound_m(recording.camera, landmark, truth.T_landmark_camera, *quality) : 0;
}

}  // namespace

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

CaseScore score_case(const CaseFolder& recording) {
  CaseScore score{recording.name, {}, static_cast<int>(recording.frames.size()), 0};
  Localiser localiser(recording.camera, LocaliserOptions{});
  Report report;
  for (const CaseFrame& picture : recording.frames) {
    const MonoTime started = mono_now();
    test::process_picture(localiser, recording.view(picture), mono_from_ns(picture.timestamp_ns + 1),
                          static_cast<std::uint64_t>(picture.number), report);
    const double process_us = std::chrono::duration<double, std::micro>(mono_now() - started).count();

    std::vector<Shot> shots;
    for (const TruePose& truth : picture.landmarks)
      shots.push_back({picture.number, truth, false, 0, 0, 0, bound_of(recording, picture, truth), process_us});
    if (report.valid) {
      const Eigen::Vector3d position_m = reported_pose(report).translation_m;
      const auto distance_m = [&](const Shot& shot) {
        return (shot.truth.T_landmark_camera.translation_m - position_m).norm();
      };
      const auto nearest = std::min_element(
          shots.begin(), shots.end(), [&](const Shot& a, const Shot& b) { return distance_m(a) < distance_m(b); });
      if (nearest == shots.end() || distance_m(*nearest) > kMaxRelativeError * nearest->truth.distance_m()) {
        ++score.false_landmarks;
      } else {
        compare(report, *nearest);
      }
    }
    score.shots.insert(score.shots.end(), shots.begin(), shots.end());
  }
  return score;
}

}  // namespace ninedot::bench
