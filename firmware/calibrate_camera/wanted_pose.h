#pragma once
/// How somebody would have to hold the sheet so that a view that is wanted is there: for a ghost in the picture that
/// they bring it to.
#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "calibrate_camera/sheet_map.h"
#include "calibrate_camera/sufficiency.h"
#include "calibrate_camera/view_collection.h"
#include "geometry/camera_model.h"
#include "geometry/transform.h"

namespace ninedot {

struct WantedPose {
  CameraFromLandmark T_camera_sheet;
  std::vector<std::size_t> meets;  ///< which of the wanted views it gives at once, by their index; the first is 0
};

/// The sheet wholly in the picture, facing the camera or turned by 36 degrees, so that it gives the first of the wanted
/// views, as many others as one way of holding it can, and none that there is already.
/// \param wanted  as wanted_views has them \param lens  as it is known by now, for pictures of its size
/// \param views  that there are
/// \return  nothing: nothing is wanted, or no such pose shows the sheet whole through this lens
/// Memory: allocates. Threads: pure; 720 poses are tried at most.
std::optional<WantedPose> pose_for(std::span<const Want> wanted, const CameraModel& lens,
                                   std::span<const PlaneDisc> discs, const ViewCollection& views);

/// What the sheet and its discs look like: closed polygons, in px of the picture.
/// \param map  from the sheet to the picture
/// \return  [px] first the sheet's border, its sides bent as the lens bends them, then the discs in their order; of a
/// sheet with more than kMostOutlined discs the border alone
std::vector<std::vector<Eigen::Vector2d>> outlines_of(const SheetMap& map, std::span<const PlaneDisc> discs);
inline constexpr std::size_t kMostOutlined = 9;  ///< discs

}  // namespace ninedot
