#include "programs/assembly/localiser_options.h"

#include <algorithm>

#include "base/startup_error.h"
#include "base/units.h"
#include "world/landmark_map.h"

namespace ninedot {

LocaliserOptions localiser_options(const Config& config) {
  const bool any_code =
      std::ranges::any_of(config.landmarks, [](const auto& landmark) { return !landmark.code.empty(); });
  if (config.landmarks.size() > 1 && !any_code)
    throw StartupError(
        ExitStatus::kWrongUsage,
        "[[landmarks]]: black-and-white landmarks look alike, so that only one can be told from the rest: "
        "keep one entry");
  LocaliserOptions options;
  options.landmark = {config.landmark.ring_radius_mm * kMetresPerMm, config.landmark.dot_diameter_mm / 2 * kMetresPerMm,
                      config.landmark.centre_diameter_mm / 2 * kMetresPerMm};
  options.detector.upright = {config.landmark.expected_roll_deg * kRadPerDeg,
                              config.landmark.roll_sigma_deg * kRadPerDeg};
  options.solver = config.pose.solver == "ellipse" ? Solver::kEllipse : Solver::kFull;
  const EllipseConfig& e = config.ellipse;
  options.ellipse = {e.kmm_mm_per_px, e.p1, e.p2, e.p3, e.cu, e.cv};
  options.tracking = config.pose.tracking;
  options.trust = {config.pose.max_ambiguity, config.pose.max_sigma_percent / 100};
  if (!config.landmarks.empty()) {
    const MapLandmarkConfig& landmark = config.landmarks.front();
    if (any_code)
      throw StartupError(ExitStatus::kWrongUsage,
                         "[[landmarks]]: this version does not read colour codes yet: leave `code` out for a "
                         "black-and-white landmark");
    const Eigen::Vector3d position_m = Eigen::Vector3d(landmark.x_mm, landmark.y_mm, landmark.z_mm) * kMetresPerMm;
    options.map = LandmarkMap({{static_cast<std::uint16_t>(landmark.id), landmark.code,
                                place_upright(position_m, landmark.heading_deg * kRadPerDeg)}});
  }
  return options;
}

}  // namespace ninedot
