#pragma once
/// How far the axes of the Sony EVI-D30 and EVI-D31 turn.
///
/// The tables "D30/D31 mode" of Sony's "EVI-D100/D100P Technical Manual" (A-AYT-100-11), pp. 42-45, and of the
/// "EVI-D70/D70P Technical Manual" (A-BS4-100-11), pp. 54-58: pan FC90h..0370h = -100..+100 deg, and steps up turn to
/// the right; tilt FED4h..012Ch = -25..+25 deg. That positive tilt is up: the driver jhcPTZ.cpp of J. H. Connell (IBM,
/// 2002-2013, Apache licence).

namespace ninedot {

inline constexpr int kEviD31MaxPanSteps = 0x370, kEviD31MaxTiltSteps = 0x12C;
inline constexpr double kEviD31MaxPan_deg = 100, kEviD31MaxTilt_deg = 25;

}  // namespace ninedot
