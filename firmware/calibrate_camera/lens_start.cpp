#include "calibrate_camera/lens_start.h"

#include <cmath>

#include "calibrate_camera/sheet_map.h"

namespace ninedot {

std::optional<double> focal_from_homographies(std::span<const SheetView> views, std::span<const PlaneDisc> discs,
                                              int width_px, int height_px) {
  Eigen::Matrix3d to_middle = Eigen::Matrix3d::Identity();
  to_middle(0, 2) = -0.5 * (width_px - 1), to_middle(1, 2) = -0.5 * (height_px - 1);
  double squares = 0, product = 0;
  for (const SheetView& view : views) {
    Eigen::Matrix3d H;
    if (!fit_sheet_map(view.seen, discs, H)) continue;
    H = (to_middle * H).eval();
    H /= H.topLeftCorner<2, 2>().norm();  // so that near views count no more than distant ones
    const Eigen::Vector2d a = H.col(0).head<2>(), b = H.col(1).head<2>();
    // a.b / f^2 + h31 h32 = 0 and (a.a - b.b) / f^2 + h31^2 - h32^2 = 0
    const Eigen::Vector2d slope(a.dot(b), a.squaredNorm() - b.squaredNorm());
    const Eigen::Vector2d rest(H(2, 0) * H(2, 1), H(2, 0) * H(2, 0) - H(2, 1) * H(2, 1));
    squares += slope.squaredNorm(), product -= slope.dot(rest);
  }
  const double focal_px = std::sqrt(squares / product);
  const bool is_plausible = product > 0 && focal_px > 0.15 * width_px && focal_px < 50 * width_px;
  return is_plausible ? std::optional(focal_px) : std::nullopt;
}

}  // namespace ninedot
