#pragma once
/// A lens by mrcal (Debian's package `mrcal`; mrcal.secretsauce.net), from the same views of a grid of dots.
#include <optional>
#include <span>

#include "calibrate_camera/sheet_view.h"
#include "geometry/camera_model.h"
#include "geometry/dot_grid.h"

namespace ninedot {

/// Whether its mrcal-calibrate-cameras is installed.
bool has_mrcal();

/// LENSMODEL_OPENCV5 for plumb_bob, else LENSMODEL_OPENCV8: it has no equidistant one.
/// \param like  whose size and model are meant, and whose focal length it starts from
/// \param views  seen[].centre_px are taken as pictures of the dots' middles
/// \return  nothing: it failed
std::optional<CameraModel> lens_by_mrcal(const CameraModel& like, const DotGrid& grid,
                                         std::span<const SheetView> views);

}  // namespace ninedot
