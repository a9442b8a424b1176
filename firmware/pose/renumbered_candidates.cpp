#include "pose/renumbered_candidates.h"

#include "geometry/renumbered.h"
#include "pose/ellipse_parameters.h"

namespace ninedot {

PoseCandidates renumbered(const PoseCandidates& candidates, int eighths, const CameraModel& camera,
                          const LandmarkGeometry& landmark) noexcept {
  constexpr int kDots = kRingDotCount;
  PoseCandidates out = candidates;
  out.rival.reset();
  Matrix6d turn = Matrix6d::Identity();
  turn.topLeftCorner<3, 3>() = R_renumbered_sheet(eighths);
  for (std::size_t i = 0; i < out.list.size(); ++i) {
    const PoseCandidate& before = candidates.list[i];
    PoseCandidate& after = out.list[i];
    after.outlines.T_camera_landmark = renumbered(before.outlines.T_camera_landmark, eighths);
    after.pose.T_landmark_camera = renumbered(before.pose.T_landmark_camera.inverse(), eighths).inverse();
    after.pose.covariance = turn * before.pose.covariance * turn.transpose();
    after.pose.ellipse = ellipse_parameters(after.pose.T_landmark_camera, camera, landmark);
    after.dots = renumbered(before.dots, eighths);
    for (int dot = 0; dot < kDots; ++dot)
      after.visible_share[static_cast<std::size_t>(dot)] =
          before.visible_share[static_cast<std::size_t>(((dot + eighths) % kDots + kDots) % kDots)];
  }
  return out;
}

}  // namespace ninedot
