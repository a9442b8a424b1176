#pragma once
/// Whether views are enough for a calibration, and what is missing where they are not.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "calibrate_camera/lens_calibration.h"

namespace ninedot {

/// Nine parts of a picture, row by row.
inline constexpr std::array<const char*, 9> kPartNames{"upper left", "top",    "upper right", "left", "middle", "right",
                                                       "lower left", "bottom", "lower right"};
/// Of how many views a disc's middle lies in each part.
std::array<int, 9> views_by_part(std::span<const SheetView> views, int width_px, int height_px);

/// What can be said before any lens is fitted: too few views, one place only, empty parts of the picture.
/// \param found  number of pictures that show the sheet, those that repeat others included
/// \return  a line each; none: go on
std::vector<std::string> what_views_lack(std::span<const SheetView> views, std::size_t found, int width_px,
                                         int height_px);

/// What the calibration itself says: a focal length or directions too uncertain, views that contradict each other.
/// \return  a line each; none: it may be used
std::vector<std::string> what_lens_lacks(const LensCalibration& calibration);

}  // namespace ninedot
