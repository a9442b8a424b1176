#pragma once
/// What the dots of one picture say of the time from row to row of a rolling shutter, when it is known how their sheets
/// move: where the camera stands is unknown as well, and eliminated. A shear looks like a tilt, and says little; sheets
/// in different rows that hang still say much.
///
/// Residual of a dot = ray(p) - seen + (row - middle row) * (speed of its ray) * d, with the camera's place p and the
/// error d of the row time that was assumed. The rays and their derivatives by p are those of sighting_fit.h.
#include <optional>

#include "geometry/camera_model.h"
#include "geometry/sheet_motion.h"
#include "world/joint_fit.h"

namespace ninedot {

/// Gauss-Newton's equations of a PoseStep of the camera [m, rad] and of the row time's error [s]; they add up over the
/// sightings of a picture.
struct RowTimeEquations {
  double chi2 = 0;  ///< of all dots seen [1]
  Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> gradient = Eigen::Matrix<double, 7, 1>::Zero();

  RowTimeEquations& operator+=(const RowTimeEquations& other) noexcept;
};

/// Of one member, the uncertainty of its landmark's place eliminated as in fit_of_member.
/// \param taken_by  what its dots were taken to the middle row with, and the row time that was assumed
/// \param motion  how its sheet moved, as is known now: what they were taken by too much is taken back
/// \return  chi2 infinite, the rest zero: a dot that is seen would lie behind the camera; zero: none is seen
/// Memory: none. Threads: pure.
RowTimeEquations equations_of_member(const JointMember& member, const SheetMotion& taken_by, const SheetMotion& motion,
                                     const WorldFromCamera& T_world_camera, const LandmarkGeometry& landmark,
                                     const CameraModel& camera) noexcept;

/// What is left of them for the row time, the place eliminated.
struct RowTimeEvidence {
  double error_s = 0;           ///< of the row time that was assumed, the likeliest
  double information_1_s2 = 0;  ///< 1 / variance of `error_s`, by the dots alone [1/s^2]
  double motion_share = 0;  ///< 1-sigma of how fast the sheets moved, as a share: the row time is off by as much [1]
  /// What prints, warped sheets and places in the map that are a little off would make of a row time, in every picture
  /// alike, 1-sigma.
  double unexplained_s = 0;
  bool is_of_left_out = false;  ///< a sighting that the world solver had left out is one of those that agree by it
  PoseStep step_by_row_time = PoseStep::Zero();  ///< how the place moves with the row time [m/s, rad/s]
  PoseStep step = PoseStep::Zero();              ///< to the likeliest place [m, rad]
};

/// \return  none: the dots determine no place
/// Memory: none. Threads: pure.
std::optional<RowTimeEvidence> evidence_of(const RowTimeEquations& equations) noexcept;

}  // namespace ninedot
