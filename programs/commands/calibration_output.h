#pragma once
/// What `ninedot calibrate camera` writes and says of a lens that it has found, and `calibrate zoom` of each of its
/// own.
#include <span>
#include <string>
#include <vector>

#include "calibrate/camera_file_text.h"
#include "calibrate_camera/lens_calibration.h"

namespace ninedot {

/// "plumb_bob: fx 612.31 +- 0.05, ...".
std::string summary_of(const LensCalibration& result);

/// Where more views would make it better, one line; empty: nowhere.
std::string wish_for_views(const LensCalibration& result);

/// What became of the lens models, a line each. \param is_forced  by --model
std::vector<std::string> model_lines(const LensCalibration& result, bool is_forced);

/// What a calibration file says of it, of today, but for the comments. \param lens  what a person calls it; may be
/// empty
CalibrationNotes calibration_notes(const LensCalibration& result, const std::string& lens);

/// A camera's name from the file that its calibration goes to; what YAML might not take for a letter is "_".
std::string camera_name_of(const std::string& out);

/// The SVG file beside `out`, unless `picture` names another one; empty: none, as beside standard output and devices.
std::string picture_beside(const std::string& out, const std::string& picture);

/// The text of camera.yaml, of today. \param name  as ROS has it \param lens  what a person calls it; may be empty
std::string camera_file_of(const LensCalibration& result, const std::string& name, const std::string& lens,
                           bool is_forced);

/// SVG: coverage, residuals, expected errors of directions. \param discs  of the sheet
std::string picture_of(const LensCalibration& result, std::span<const PlaneDisc> discs);

}  // namespace ninedot
