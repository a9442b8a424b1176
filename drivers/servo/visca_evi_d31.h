#pragma once
/// The zoom of the Sony EVI-D30 and EVI-D31: 0000h (wide) to 03FFh (tele), by Sony's "EVI-D70/D70P Technical Manual"
/// (A-BS4-100-11), pp. 54-58.
namespace ninedot {

inline constexpr int kEviD31MaxZoom = 0x3FF;  ///< [steps]

}  // namespace ninedot
