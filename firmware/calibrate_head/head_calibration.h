#pragma once
/// How a pan/tilt head is made and how it tells its angles, from stops at which its camera saw landmarks that hang
/// still.
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "calibrate_head/head_network.h"

namespace ninedot {

struct TablePoint {
  double told_rad = 0, angle_rad = 0;
  double sigma_rad = 0;  ///< of angle_rad, against the anchor's; 1-sigma
};

struct AxisCalibration {
  std::vector<TablePoint> points;           ///< by rising told angle, over what was travelled; two at least
  bool sees_play = false;                   ///< it came from both sides; else nothing is known of the play, and it is 0
  double play_rad = 0, play_sigma_rad = 0;  ///< between where it stands coming from below and from above
  double spread_rad = 0;                    ///< 1-sigma of true angles about the table, beside the play
  /// 1-sigma of the true angle where nobody knows from which side it came: spread, half the play, the table's own.
  double sigma_rad = 0;
};

struct HeadCalibration {
  /// As it was but for tilt_axis_m.x, camera_m, camera_rpy_rad and the two sigmas of the told angles.
  BodyGeometry body;
  double tilt_axis_x_sigma_m = 0;
  Eigen::Vector3d camera_sigma_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d camera_rpy_sigma_rad = Eigen::Vector3d::Zero();
  AxisCalibration pan, tilt;
  double skew_rad = 0, skew_sigma_rad = 0;  ///< of the tilt axis against a right angle to the pan axis; not in `body`
  /// Root mean square of the angle between where a landmark is seen and where the told angles foretell it: in stops
  /// that were left out of the fit, and with what was known before.
  double foretold_rad = 0, foretold_before_rad = 0;
  std::size_t stops = 0, left_out = 0;  ///< how many were used; how many contradict them
  std::size_t landmarks = 0;
  double variance_factor = 1;  ///< of the pictures against what they say of themselves; in all sigmas [1]
};

/// \param stops   five at least (contract); whether they suffice, head_sufficiency.h says
/// \param before  what the configuration says; its camera_rpy_rad decides what is up
/// \param go_on   asked often; false ends the work; may be empty
/// \return  none: nothing explains the stops, or it was told to stop
/// Memory: allocates. Threads: one.
std::optional<HeadCalibration> calibrate_head(std::span<const HeadStop> stops, const LandmarkGeometry& landmark,
                                              const BodyGeometry& before, const std::function<bool()>& go_on);

}  // namespace ninedot
