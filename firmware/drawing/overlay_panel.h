#pragma once
/// The panel of numbers beside an overlay picture.
#include <opencv2/core.hpp>

#include "report/report.h"

namespace ninedot::overlay {

/// Everything in the panel is laid out in units; one unit is a 960th of the least height that holds all of it.
inline constexpr double kPanelWidth_units = 440, kPanelHeight_units = 960;

/// Where the magnified cut-out of a small landmark goes: a square, the panel's width without the margins of its text.
inline constexpr double kInsetLeft_units = 30, kInsetTop_units = 468, kInsetSide_units = 380;

/// What the picture's colours mean.
enum class KeyOf : bool { kLandmark, kFailedSearch };

/// Fills `panel` (CV_8UC3, red green blue) with the verdict, the numbers and the key to the colours.
/// \param unit_px  pixels of one unit
void draw_panel(cv::Mat& panel, const Report& report, KeyOf key, double unit_px);

}  // namespace ninedot::overlay
