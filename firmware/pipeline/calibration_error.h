#pragma once
/// A calibration's own uncertainty in poses and in places of the camera in the world.
///
/// It is one error for all landmarks and all frames: each answer gets its share once, when everything else is done, and
/// the track's filter, which would average it down, never sees it.
#include <optional>
#include <span>

#include "pose/estimate.h"
#include "world/calibration_share.h"

namespace ninedot {

/// Memory: none beyond itself. Threads: const is safe.
class CalibrationError {
 public:
  /// \param intrinsics  of the calibration [px^2, px, 1]; none: it does not say how good it is
  CalibrationError(const CameraModel& camera, const LandmarkGeometry& landmark,
                   const std::optional<IntrinsicCovariance>& intrinsics) noexcept
      : camera_(camera), landmark_(landmark), intrinsics_(intrinsics) {}

  /// false: there is nothing to add, and no share may be asked for.
  bool is_known() const noexcept { return intrinsics_.has_value(); }

  /// What it adds to the covariance of one landmark's pose. \pre is_known() (contract)
  /// \return  [m^2, m rad, rad^2]
  Matrix6d share_of(const PoseCandidate& candidate) const noexcept;

  /// What it adds to a place of the camera that these members gave. \pre is_known() (contract)
  /// \return  of a PoseStep [m^2, m rad, rad^2]
  PoseInformation share_of(std::span<const JointMember> members, const WorldFromCamera& T_world_camera) const noexcept;

 private:
  CameraModel camera_;
  LandmarkGeometry landmark_;
  std::optional<IntrinsicCovariance> intrinsics_;
};

/// 1-sigma of the position, all axes together [m]. \param covariance  position first [m^2]
double position_sigma_m(const Matrix6d& covariance) noexcept;

}  // namespace ninedot
