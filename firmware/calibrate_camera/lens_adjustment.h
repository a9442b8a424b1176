#pragma once
/// Lens and sheets together: the parameters that explain the outlines in all views best.
///
/// Z. Zhang, "A flexible new technique for camera calibration", PAMI 2000, section 3.2, with outlines of discs in place
/// of points; solved by Ceres Solver with the views eliminated first (Schur complement).
#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "calibrate_camera/view_fit.h"

namespace ninedot {

/// A lens, and where the sheets were.
struct LensFit {
  CameraModel camera;
  std::vector<ViewState> views;  ///< as the views that it was fitted to, in their order
  double floor_px = 0;           ///< what outlines are off beside their own sigmas; 1-sigma
  double loss = 0;               ///< half of it, over all edges [1]
};

struct AdjustLensOptions {
  int max_iterations = 60;
  /// Called after every step; false ends the work where it is.
  std::function<bool()> go_on;
};

/// Moves `fit` from where it is. \param views  as many as fit.views (contract)
/// \return  false: it can't be evaluated, or it was told to stop
bool adjust_lens(std::span<const PlaneDisc> discs, std::span<const SheetView> views, LensFit& fit,
                 const AdjustLensOptions& options);

/// What the edges differ from a fit by, beyond their sigmas: with it half of them are within 0.6745 sigma. [px]
double unexplained_px(std::span<const PlaneDisc> discs, std::span<const SheetView> views, const LensFit& fit);

}  // namespace ninedot
