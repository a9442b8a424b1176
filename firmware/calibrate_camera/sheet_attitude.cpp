// Near its middle a sheet is seen through the Jacobian of its homography. A sheet that is tilted by t is seen shorter
// by cos t across the axis of the tilt, and what is further away is seen smaller.
#include "calibrate_camera/sheet_attitude.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "calibrate_camera/sheet_map.h"

namespace ninedot {

std::optional<SheetAttitude> attitude_of(std::span<const SeenDisc> seen, std::span<const PlaneDisc> discs,
                                         int height_px) {
  Eigen::Matrix3d H;
  if (!fit_sheet_map(seen, discs, H)) return std::nullopt;
  Eigen::Vector2d middle_m{0, 0};
  for (const PlaneDisc& disc : discs) middle_m += disc.centre_m / static_cast<double>(discs.size());
  double radius_m = 0;
  for (const PlaneDisc& disc : discs) radius_m = std::max(radius_m, (disc.centre_m - middle_m).norm());

  const Eigen::Matrix2d px_per_m = jacobian_of_map(H, middle_m);
  const Eigen::JacobiSVD<Eigen::Matrix2d> svd(px_per_m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double shorter = svd.singularValues()(1) / svd.singularValues()(0);
  const Eigen::Vector2d across_m = radius_m * svd.matrixV().col(1);
  const double ahead = std::abs(jacobian_of_map(H, middle_m + across_m).determinant());
  const double behind = std::abs(jacobian_of_map(H, middle_m - across_m).determinant());
  SheetAttitude attitude;
  attitude.middle_px = map_point(H, middle_m);
  attitude.height_share = 2 * radius_m * svd.singularValues()(0) / height_px;
  attitude.tilt_rad = std::acos(std::clamp(shorter, 0.0, 1.0));
  attitude.away = ahead < behind ? svd.matrixU().col(1) : Eigen::Vector2d(-svd.matrixU().col(1));
  return attitude;
}

}  // namespace ninedot
