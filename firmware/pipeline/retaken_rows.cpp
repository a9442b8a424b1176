#include "pipeline/retaken_rows.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "world/sighting_fit.h"

namespace ninedot {
namespace {

/// A thousandth of a pixel: what no dot moves by moves no pose. [1]
constexpr double kNothing = 1e-6;

}  // namespace

void retake_rows(PoseCandidate& fitted, const SheetMotion& taken, const SheetMotion& motion,
                 const LandmarkGeometry& landmark, const CameraModel& camera) noexcept {
  if (taken.row_time_s == 0) return;
  const auto& T_landmark_camera = fitted.pose.T_landmark_camera;
  const CameraFromLandmark T_camera_landmark = T_landmark_camera.inverse();
  const Eigen::Vector3d& t_m = T_camera_landmark.translation_m;
  // The pose goes where the moved dots have it, each by its weight: one step of Gauss and Newton's.
  PoseInformation normal = PoseInformation::Zero();
  PoseStep pull = PoseStep::Zero();
  double farthest = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    DotSighting& seen = fitted.dots[dot];
    if (seen.information.isZero(0)) continue;
    const Eigen::Vector2d on_sheet_m = landmark.centre_m(dot);
    const Eigen::Vector3d p_m = T_camera_landmark * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
    const double since_s = taken.since_s(camera.pixel_from_normalised(seen.ray).y());
    const Eigen::Vector2d by = since_s * (taken.ray_velocity(p_m, t_m) - motion.ray_velocity(p_m, t_m));
    seen.ray += by;
    farthest = std::max(farthest, by.lpNorm<Eigen::Infinity>());
    const Eigen::Matrix<double, 2, 6> J = ray_by_step(p_m, T_landmark_camera.rotation);
    const Eigen::Matrix<double, 6, 2> weighted = J.transpose() * seen.information;
    normal += weighted * J;
    pull += weighted * by;
  }
  const Eigen::LLT<PoseInformation> solver(normal);
  if (farthest < kNothing || solver.info() != Eigen::Success) return;
  const WorldFromCamera at =
      moved_by(WorldFromCamera{T_landmark_camera.rotation, T_landmark_camera.translation_m}, solver.solve(pull));
  fitted.pose.T_landmark_camera = {at.rotation, at.translation_m};
}

}  // namespace ninedot
