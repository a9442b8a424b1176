#pragma once
/// Where a sheet was before a camera that is taken as known, from the outlines of its discs in one picture.
#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "calibrate_camera/sheet_view.h"
#include "geometry/camera_model.h"
#include "geometry/transform.h"

namespace ninedot {

/// One view's own unknowns.
struct ViewState {
  CameraFromLandmark T_camera_sheet;
  double offset_px = 0;  ///< all outlines are seen this much further out: tone curve, ink that spreads
};

/// Cauchy's loss: an outline so many sigmas off has half of its influence. A twentieth of the information is lost where
/// all are as they should be. (P. J. Huber, "Robust Statistics", 1981, table of efficiencies: c = 2.385 has 95 %.) [1]
inline constexpr double kLoss_sigmas = 2.385;

/// What an outline's place is off by beside the picture's noise: print, paper, lens. \return  [px], 1-sigma of both
inline double total_sigma_px(const EdgePoint& edge, double floor_px) noexcept {
  return std::sqrt(edge.sigma_px * edge.sigma_px + floor_px * floor_px);
}

struct ViewFit {
  ViewState state;
  double loss = 0;  ///< half of it, over all edges [1]
};

/// \param floor_px  as total_sigma_px takes it
/// \return  nothing: too few discs, or none of the two planar poses shows all outlines
/// Memory: allocates. Threads: pure.
std::optional<ViewFit> fit_view(const CameraModel& camera, std::span<const PlaneDisc> discs, const SheetView& view,
                                double floor_px, const ViewState* start = nullptr);

/// Signed distances of the edges from where a state shows the outlines; not a number where it shows none. [px]
std::vector<double> edge_residuals_px(const CameraModel& camera, std::span<const PlaneDisc> discs,
                                      const SheetView& view, const ViewState& state);

}  // namespace ninedot
