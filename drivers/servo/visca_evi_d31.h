#pragma once
/// The lens of the Sony EVI-D30 and EVI-D31.
///
/// Zoom 0000h (wide) to 03FFh (tele): Sony's "EVI-D70/D70P Technical Manual" (A-BS4-100-11), pp. 54-58. The ends of the
/// focal length: the driver jhcPTZ.cpp of J. H. Connell (IBM, 2002-2013, Apache licence), which agrees with the
/// 48.8 deg of horizontal view at the wide end on p. 54 of that manual.
#include <array>

#include "drivers/servo/visca_zoom_table.h"

namespace ninedot {

inline constexpr int kEviD31MaxZoom = 0x3FF;  ///< [steps]

/// The two ends that are documented. Between them the lens does not follow a straight line: measure what you use.
inline constexpr std::array<ZoomPoint, 2> kEviD31Zoom = {{{0, 5.4}, {kEviD31MaxZoom, 64.8}}};

}  // namespace ninedot
