#include "pipeline/retaken_rows.h"

#include <Eigen/Cholesky>

#include "world/sighting_fit.h"

namespace ninedot {

void retake_rows(PoseCandidate& fitted, const SheetMotion& taken, const SheetMotion& motion,
                 const LandmarkGeometry& landmark, const CameraModel& camera) noexcept {
  if (taken.row_time_s == 0) return;
  const auto& T_landmark_camera = fitted.pose.T_landmark_camera;
  const CameraFromLandmark T_camera_landmark = T_landmark_camera.inverse();
  const WorldFromCamera before{T_landmark_camera.rotation, T_landmark_camera.translation_m};
  const auto point = [&](std::size_t dot) -> Eigen::Vector3d {
    const Eigen::Vector2d on_sheet_m = landmark.centre_m(dot);
    return T_camera_landmark * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
  };
  const LandmarkSighting seen{0, T_camera_landmark, fitted.dots};
  LandmarkSighting retaken = seen;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (seen.dots[dot].information.isZero(0)) continue;
    const Eigen::Vector3d p_m = point(dot);
    const double since_s = taken.since_s(camera.pixel_from_normalised(seen.dots[dot].ray).y());
    retaken.dots[dot].ray -= since_s * (motion.ray_velocity(p_m, T_camera_landmark.translation_m) -
                                        taken.ray_velocity(p_m, T_camera_landmark.translation_m));
  }
  fitted.dots = retaken.dots;
  const SightingFit as_fitted = fit_of_sighting(seen, {}, before, landmark);
  const SightingFit now = fit_of_sighting(retaken, {}, before, landmark);
  const Eigen::LLT<PoseInformation> normal(as_fitted.normal);
  if (normal.info() != Eigen::Success) return;
  const WorldFromCamera after = moved_by(before, normal.solve(as_fitted.gradient - now.gradient));
  fitted.pose.T_landmark_camera = {after.rotation, after.translation_m};
}

}  // namespace ninedot
