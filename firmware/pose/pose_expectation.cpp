#include "pose/pose_expectation.h"

#include <cmath>

#include "pose/mirror_image.h"

namespace ninedot {
namespace {

// Times the residual of the frame before, and a bit (what one frame's residual scatters by): something else is in
// sight.
constexpr double kWorseFit = 1.5, kBit_px = 0.03;
// Times the 1-sigma of the frame before: the same dots in the same light are as certain, to a third; another reading of
// them is not.
constexpr double kLessCertain = 3;
// From the expected pose: within its uncertainty, and what a head or a robot turns in a frame beyond the motion of the
// frame before.
constexpr double kExpectedSigmas = 6, kUnforetoldTurn_rad = 0.03;

double position_variance_m2(const Matrix6d& C) noexcept { return C.topLeftCorner<3, 3>().trace(); }
double rotation_variance_rad2(const Matrix6d& C) noexcept { return C.bottomRightCorner<3, 3>().trace(); }

}  // namespace

bool PoseExpectation::lacks_dots(const PoseCandidate& followed) const noexcept {
  return before && followed.pose.dots_used < before->dots_used;
}

bool PoseExpectation::includes(const PoseCandidate& followed) const noexcept {
  if (!before) return true;
  const Matrix6d &then = before->covariance, &now = followed.pose.covariance;
  const double turn_rad = angle_between_rad(T_camera_landmark, followed.pose.T_landmark_camera.inverse());
  return !lacks_dots(followed) && followed.pose.rms_px <= kWorseFit * before->rms_px + kBit_px &&
         position_variance_m2(now) <= kLessCertain * kLessCertain * position_variance_m2(then) &&
         rotation_variance_rad2(now) <= kLessCertain * kLessCertain * rotation_variance_rad2(then) &&
         turn_rad <= kUnforetoldTurn_rad +
                         kExpectedSigmas * std::sqrt(rotation_variance_rad2(then) + rotation_variance_rad2(now));
}

}  // namespace ninedot
