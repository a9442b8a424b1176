#pragma once
/// What is known of the Sony EVI-D30 and EVI-D31.
///
/// Positions and speeds: the tables "D30/D31 mode" of Sony's "EVI-D100/D100P Technical Manual" (A-AYT-100-11), pp.
/// 42-45, and of the "EVI-D70/D70P Technical Manual" (A-BS4-100-11), pp. 54-58: pan FC90h..0370h = -100..+100 deg, and
/// steps up turn to the right; tilt FED4h..012Ch = -25..+25 deg; zoom 0000h (wide) to 03FFh (tele). That positive tilt
/// is up, and the ends of the focal length: the driver jhcPTZ.cpp of J. H. Connell (IBM, 2002-2013, Apache licence),
/// which agrees with the 48.8 deg of horizontal view at the wide end on p. 54 of the EVI-D70's manual.
#include <array>

#include "drivers/servo/visca_zoom_table.h"

namespace ninedot {

inline constexpr int kEviD31MaxPanSteps = 0x370, kEviD31MaxTiltSteps = 0x12C;
inline constexpr double kEviD31MaxPan_deg = 100, kEviD31MaxTilt_deg = 25;
inline constexpr int kEviD31MaxZoom = 0x3FF;

/// The two ends that are documented. Between them the lens does not follow a straight line: measure what you use.
inline constexpr std::array<ZoomPoint, 2> kEviD31Zoom = {{{0, 5.4}, {kEviD31MaxZoom, 64.8}}};

}  // namespace ninedot
