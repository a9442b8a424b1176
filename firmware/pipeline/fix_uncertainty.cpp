#include "pipeline/fix_uncertainty.h"

#include "pipeline/picture_row_time.h"

namespace ninedot {

void set_sighting(LandmarkFix& fix, const RowMotion& rows, double row_time_sigma_s, const LandmarkGeometry& landmark,
                  const CameraModel& camera) noexcept {
  PoseCandidate& believed = fix.candidates.list[fix.chosen];
  fix.row_motion = rows;
  fix.sighting = {fix.id, believed.pose.T_landmark_camera.inverse(), believed.dots};
  widen_by_smear(fix.sighting, believed.outlines, camera);
  widen_by_smear(believed.pose, believed.outlines, camera);
  widen(believed.pose, rows.uncertainty, camera);
  believed.pose.covariance += row_time_share(fix.sighting, rows.sheet, row_time_sigma_s, landmark, camera);
}

}  // namespace ninedot
