#include "pipeline/sighting_uncertainty.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "world/sighting_fit.h"

namespace ninedot {
namespace {

// Of a line that dots draw, what its middle is off by: 0.03 px of 7 to 10 px (SmearedView's views), where 1-sigma of
// the dots together is 0.02 px.
constexpr double kUnevenShare = 0.005;

// The longer the line, the more of it runs into other dots and the wall. From here on the dots' places about each other
// were off by more than they claimed: at 10 px by a chi^2 of 12 to 14 of six freedoms (likewise).
constexpr double kFaithful_px = 7;

double line_of(const OutlineState& outlines) noexcept { return Smear(outlines).line_px.norm(); }

/// By which all dots of a landmark seem to have moved. [rad]
double uneven_rad(double line_px, const CameraModel& camera) noexcept { return kUnevenShare * line_px / camera.fx_px; }

/// By how much the variances are larger.
double variance_factor(double line_px) noexcept { return std::max(1.0, std::pow(line_px / kFaithful_px, 2)); }

/// The camera about its own centre, each axis, and with it what it says of the landmark. \param variance  [rad^2]
void turn(PoseEstimate& pose, double variance) noexcept {
  pose.covariance.topLeftCorner<3, 3>().diagonal().array() +=
      variance * pose.T_landmark_camera.translation_m.squaredNorm();
  pose.covariance.bottomRightCorner<3, 3>().diagonal().array() += variance;
}

}  // namespace

void widen(LandmarkSighting& sighting, const RowUncertainty& rows, const CameraModel& camera, bool may_move) noexcept {
  const double per_row_rad = rows.per_row_rad(may_move);
  if (per_row_rad == 0) return;
  const double row_px = camera.pixel_from_normalised(sighting.T_camera_landmark.translation_m.hnormalized()).y();
  sighting.turn_sigma_rad = std::hypot(sighting.turn_sigma_rad, per_row_rad * (row_px - rows.middle_row_px));
  int seen = 0;
  for (const DotSighting& dot : sighting.dots) seen += !dot.information.isZero(0);
  for (DotSighting& dot : sighting.dots) {
    if (dot.information.isZero(0)) continue;
    const double dot_row_px = camera.pixel_from_normalised(dot.ray).y();
    const double own = per_row_rad * (dot_row_px - row_px);
    // (A^-1 + v 1)^-1 = (1 + v A)^-1 A; as often as there are dots, since the sum over them takes it for their own.
    const double variance = seen * own * own;
    dot.information = (Eigen::Matrix2d::Identity() + variance * dot.information).inverse() * dot.information;
  }
}

void widen(PoseEstimate& pose, const RowUncertainty& rows, const CameraModel& camera) noexcept {
  if (rows.of_motion_rad == 0) return;
  const Eigen::Vector3d t_m = pose.T_landmark_camera.inverse().translation_m;
  const double row_px = camera.pixel_from_normalised(t_m.hnormalized()).y();
  const double turn_rad = rows.of_motion_rad * (row_px - rows.middle_row_px);
  // From row to row the picture is sheared by rate times row time times focal length: about as much of a turn.
  const double shear_rad = rows.of_motion_rad * camera.fy_px;
  turn(pose, turn_rad * turn_rad + shear_rad * shear_rad);
}

void widen_by_scatter(LandmarkSighting& sighting, const LandmarkGeometry& landmark) noexcept {
  const auto T_landmark_camera = sighting.T_camera_landmark.inverse();
  const SightingFit own =
      fit_of_sighting(sighting, {}, {T_landmark_camera.rotation, T_landmark_camera.translation_m}, landmark);
  const double per_freedom = own.dots > 3 ? own.chi2 / (2 * own.dots - 6) : 1;
  if (!(per_freedom > 1)) return;
  for (DotSighting& dot : sighting.dots) dot.information /= per_freedom;
}

void widen_by_smear(LandmarkSighting& sighting, const OutlineState& outlines, const CameraModel& camera) noexcept {
  const double line_px = line_of(outlines);
  sighting.turn_sigma_rad = std::hypot(sighting.turn_sigma_rad, uneven_rad(line_px, camera));
  for (DotSighting& dot : sighting.dots) dot.information /= variance_factor(line_px);
}

void widen_by_smear(PoseEstimate& pose, const OutlineState& outlines, const CameraModel& camera) noexcept {
  const double line_px = line_of(outlines), turn_rad = uneven_rad(line_px, camera);
  pose.covariance *= variance_factor(line_px);
  turn(pose, turn_rad * turn_rad);
}

}  // namespace ninedot
