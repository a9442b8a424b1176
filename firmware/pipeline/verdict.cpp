#include "pipeline/verdict.h"

#include <cmath>

namespace ninedot {

Reason verdict_on(const PoseEstimate& pose, bool fits_picture, const TrustLimits& limits) noexcept {
  if (!fits_picture) return Reason::kPoorFit;
  if (!(pose.ambiguity <= limits.max_ambiguity)) return Reason::kAmbiguous;
  const double sigma_m = std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace());
  if (!(sigma_m <= limits.max_sigma_share * pose.T_landmark_camera.translation_m.norm())) return Reason::kUncertain;
  return Reason::kNone;
}

}  // namespace ninedot
