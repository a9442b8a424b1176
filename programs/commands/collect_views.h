#pragma once
/// What recordings show of a calibration's sheet.
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate_camera/sheet_finder.h"
#include "calibrate_camera/view_collection.h"
#include "drivers/picture/picture_file.h"
#include "image/frame.h"

namespace ninedot {

/// A picture with colour is of a colour sensor.
inline SensorKind sensor_of(const Frame& frame) {
  return frame.chroma.empty() ? SensorKind::kGrey : SensorKind::kColour;
}

/// All recordings' pictures, which have one size.
struct CalibrationPictures {
  std::vector<std::string> recordings;
  PictureSize size;
};

/// Throws StartupError(kWrongUsage): a recording is not there or empty, or has pictures of another size than the first.
CalibrationPictures check_recordings(const std::vector<std::string>& recordings);

struct CollectedViews {
  ViewCollection views;
  std::size_t pictures = 0;  ///< how many were looked at
};

/// \param go_on  asked before each picture with what is going on; false ends the search, and what was gathered stays
/// Throws StartupError: kWorkFailed where a picture can't be read, kWrongUsage where one has another size.
CollectedViews collect_views(const CalibrationPictures& pictures, SheetFinder& finder, std::span<const PlaneDisc> discs,
                             const std::function<bool(const std::string& what)>& go_on);

}  // namespace ninedot
