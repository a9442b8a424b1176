#include "programs/assembly/localiser_options.h"

#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "base/units.h"
#include "programs/assembly/motion_options.h"

namespace ninedot {
namespace {

MappedLandmark mapped(const MapLandmarkConfig& landmark) {
  MappedLandmark result{static_cast<std::uint16_t>(landmark.id), landmark.code, place_of(landmark),
                        landmark.position_mm.has_value()};
  result.from_pictures = landmark.from_pictures;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<Eigen::Index>(axis);
    const double position_m = landmark.sigma_position_mm[axis] * kMetresPerMm;
    const double rotation_rad = landmark.sigma_rotation_deg[axis] * kRadPerDeg;
    result.covariance(at, at) = position_m * position_m;
    result.covariance(at + 3, at + 3) = rotation_rad * rotation_rad;
  }
  return result;
}

}  // namespace

Transform<frame::World, frame::Landmark> place_of(const MapLandmarkConfig& landmark) {
  if (!landmark.position_mm) return {};
  const Eigen::Vector3d position_m = Eigen::Map<const Eigen::Vector3d>(landmark.position_mm->data()) * kMetresPerMm;
  if (!landmark.orientation_wxyz) return place_upright(position_m, landmark.heading_deg * kRadPerDeg);
  const auto& [w, x, y, z] = *landmark.orientation_wxyz;
  return {Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix(), position_m};
}

LandmarkMap landmark_map(const Config& config) {
  if (config.landmarks.empty()) return {};
  std::vector<MappedLandmark> landmarks;
  for (const MapLandmarkConfig& landmark : config.landmarks) landmarks.push_back(mapped(landmark));
  if (landmarks.size() == 1) landmarks.front().has_place = true;
  return LandmarkMap(std::move(landmarks));
}

LocaliserOptions localiser_options(const Config& config) {
  LocaliserOptions options;
  options.seeker.landmark = {config.landmark.ring_radius_mm * kMetresPerMm,
                             config.landmark.dot_diameter_mm / 2 * kMetresPerMm,
                             config.landmark.centre_diameter_mm / 2 * kMetresPerMm};
  options.seeker.detector.upright = {config.landmark.expected_roll_deg * kRadPerDeg,
                                     config.landmark.roll_sigma_deg * kRadPerDeg};
  options.seeker.solver = config.pose.solver == "ellipse" ? Solver::kEllipse : Solver::kFull;
  const EllipseConfig& e = config.ellipse;
  options.seeker.ellipse = {e.kmm_mm_per_px, e.p1, e.p2, e.p3, e.cu, e.cv};
  std::optional<double> row_time_us = config.camera.row_time_us;
  if (config.camera.source == "simulated") row_time_us = row_time_us.value_or(0);  // its rows are all made at once then
  if (row_time_us) options.row_time = std::chrono::nanoseconds(std::llround(1000 * *row_time_us));
  options.tracking = config.pose.tracking;
  options.trust = {config.pose.max_ambiguity, config.pose.max_sigma_percent / 100};
  options.map = landmark_map(config);
  options.main_landmark = config.pose.main_landmark == "surest" ? MainLandmark::kSurest : MainLandmark::kNearest;
  options.needs_place = config.outputs.pose != "camera_in_landmark";
  options.filter = pose_filter_options(config);
  return options;
}

}  // namespace ninedot
