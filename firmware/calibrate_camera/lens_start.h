#pragma once
/// A focal length to start from, from homographies alone.
///
/// Z. Zhang, "A flexible new technique for camera calibration", PAMI 2000, equations (3) and (4): with the principal
/// point in the picture's middle, square pixels and no distortion, every view of a plane gives two equations that are
/// linear in 1 / f^2.
#include <optional>
#include <span>

#include "calibrate_camera/sheet_view.h"

namespace ninedot {

/// \param width_px, height_px  of the picture
/// \return  nothing: all views are so nearly frontal, or so bent, that the equations have no answer. [px]
std::optional<double> focal_from_homographies(std::span<const SheetView> views, std::span<const PlaneDisc> discs,
                                              int width_px, int height_px);

}  // namespace ninedot
