#pragma once
/// One hypothesis of where the camera is and how it moves: a Gaussian, and what speaks for it.
///
/// Errors that consecutive pictures have in common (calibration, the sheets' places, the dots' sub-pixel bias) do not
/// average away. The modes' `covariance`, which makes the gain, knows only what is each picture's own; the common part
/// is carried beside it as a consider state that is never estimated (S. F. Schmidt, Advances in Control Systems 3
/// (1966) 293-340).
#include <Eigen/Core>
#include <array>
#include <optional>

#include "track/crest.h"
#include "track/motion_model.h"

namespace ninedot {

/// Of the sightings' variance: what is each picture's own, and what consecutive ones have in common. Both > 0. [1]
struct ErrorShares {
  double own = 1, common = 0;
};

/// Memory: none. Threads: one caller.
struct PoseMode {
  CameraMotion motion;
  MotionCovariance covariance = MotionCovariance::Zero();         ///< of what is each picture's own [m, rad, s]
  MotionCovariance common_covariance = MotionCovariance::Zero();  ///< of what they have in common [m, rad, s]
  /// Of the state's error with the common error of the pictures, which is taken in units of its own sigma.
  Eigen::Matrix<double, 12, 6> common_cross = Eigen::Matrix<double, 12, 6>::Zero();  ///< [m, rad, s]
  std::size_t turn = 0;                                                              ///< see FrameView::fit_at [1]
  double log_motion = 0;   ///< what the way so far says for it [1]
  double log_picture = 0;  ///< what pictures say for it, see PoseFilter [1]

  double log_weight() const noexcept { return log_motion + log_picture; }
  /// Both parts together.
  MotionCovariance whole_covariance() const noexcept { return covariance + common_covariance; }  ///< [m, rad, s]

  /// Goes on by `dt_s` > 0. \param common_lasts_s  time in which the common error changes
  void predict(double dt_s, const MotionNoise& noise, double common_lasts_s) noexcept;
  /// The two halves of it on both sides of the plane through `point_m` [world] across the unit vector `across` [1]: two
  /// Gaussians of the same first moments as the halves of this one, with what each is worth. First the half where the
  /// camera is. None: less than `least_weight` lies beyond.
  std::optional<std::array<PoseMode, 2>> halved(const Eigen::Vector3d& point_m, const Eigen::Vector3d& across,
                                                double least_weight) const noexcept;
  /// Goes over to a crest that climb() found from here.
  void settle(const Crest& crest, const ErrorShares& shares) noexcept;
};

/// Its prediction as a prior. None: a covariance that is none.
std::optional<ForetoldPose> foretold_pose(const PoseMode& mode) noexcept;

/// A mode that begins at a crest under no prediction, at rest give or take the speeds.
/// \param turn  see FrameView::fit_at [1]
PoseMode mode_at_rest(const Crest& crest, std::size_t turn, const ErrorShares& shares, double speed_sigma_m_s,
                      double turning_sigma_rad_s) noexcept;

}  // namespace ninedot
