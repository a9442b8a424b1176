#include "pipeline/calibration_error.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

/// Where the dots determine no place nothing is known: a kilometre and a turn, finite so that products stay numbers.
PoseInformation share_or_nowhere(const IntrinsicsPull& pull, const IntrinsicCovariance& intrinsics) noexcept {
  if (const auto share = calibration_share(pull, intrinsics)) return *share;
  constexpr double kNowhere_m2 = 1e6, kNowhere_rad2 = 40;
  PoseInformation nowhere = PoseInformation::Zero();
  nowhere.diagonal() << kNowhere_m2, kNowhere_m2, kNowhere_m2, kNowhere_rad2, kNowhere_rad2, kNowhere_rad2;
  return nowhere;
}

/// Solver "ellipse" names no dots: those that it saw count alike.
DotSightings dots_of(const PoseCandidate& candidate) noexcept {
  const auto is_measured = [](const DotSighting& dot) { return !dot.information.isZero(0); };
  if (std::ranges::any_of(candidate.dots, is_measured)) return candidate.dots;
  DotSightings dots;
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (candidate.visible_share[dot] >= kMinVisible) dots[dot].information.setIdentity();
  return dots;
}

}  // namespace

Matrix6d CalibrationError::share_of(const PoseCandidate& candidate) const noexcept {
  const auto& T_landmark_camera = candidate.pose.T_landmark_camera;
  const LandmarkSighting sighting{0, T_landmark_camera.inverse(), dots_of(candidate)};
  const JointMember alone{&sighting, {}, nullptr};
  return share_of({&alone, 1}, {T_landmark_camera.rotation, T_landmark_camera.translation_m});
}

PoseInformation CalibrationError::share_of(std::span<const JointMember> members,
                                           const WorldFromCamera& T_world_camera) const noexcept {
  EXPECTS(is_known());
  IntrinsicsPull pull;
  for (const JointMember& member : members) pull += pull_of_member(member, T_world_camera, landmark_, camera_);
  return share_or_nowhere(pull, *intrinsics_);
}

double position_sigma_m(const Matrix6d& covariance) noexcept {
  return std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace()));
}

}  // namespace ninedot
