#pragma once
/// What a camera's tone curve makes of an outline's blur.
///
/// A pixel at an outline gets light of ink and of paper by their shares; its grey level is that light through the tone
/// curve. In a sharp picture the outlines are moved by it, all alike (OutlineState::offset_px). Of a wide blur that is
/// not all: the profile is skewed, along a motion it is moved further than across, and dots that are small beside the
/// blur are changed otherwise than P9. Taken for an offset, that displaced dots by a tenth of a pixel against P9, and
/// doubled to quintupled the pose's own 1-sigma (a point spread of 1.2 px, sRGB, 2 to 3.5 m).
///
/// Where s is the share of ink, grey levels say s + t s (1 - s) (a + b s + c s^2). The bend is that of an sRGB curve
/// (IEC 61966-2-1), exact at three shares, between the grey levels of this paper and this ink; how much of it there is,
/// t, is an unknown (OutlineState::tone): cameras have linear pictures, and curves of their own.
#include <array>
#include <span>

namespace ninedot {

/// What an sRGB curve that is taken for an offset of the outlines makes of it, between usual paper and ink: so much
/// further out. [sigmas of the blur]
inline constexpr double kToneOffset = -0.43;

/// a, b and c. [1]
using ToneBend = std::array<float, 3>;

/// An sRGB curve's. \param paper_lsb  grey level of paper, above that of ink [LSB] \param contrast_lsb  paper less ink,
/// > 0 [LSB] \return  none where there is no contrast [1]
/// Memory: none. Threads: pure.
ToneBend srgb_bend(double paper_lsb, double contrast_lsb) noexcept;

/// Grey levels of a landmark's surroundings, as an sRGB curve makes them, become light, of which ink, paper, wall and
/// all that motion smears into a pixel are sums. As bright as before where the paper is, and there with as much noise.
/// \param luma_lsb  whole grey levels, 0..255; afterwards light, in units of the paper's grey levels [LSB]
/// Memory: none. Threads: pure.
void straighten_tone(std::span<float> luma_lsb) noexcept;

}  // namespace ninedot
