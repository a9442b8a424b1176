#pragma once
/// Pixels that are dark against everything around them, whatever the light: a black top-hat with a local threshold.
///
/// The closing of a picture (dilation, then erosion, by a square) fills every dark spot narrower than the square with
/// the darkest of its surroundings, and follows slopes and the edges of hard shadows exactly, since those are wider.
/// Halfway between the closing (paper) and the local minimum (ink) is the outline of a spot. Serra, "Image Analysis and
/// Mathematical Morphology", 1982, chapter 12. Paper and ink are found at half the size: they vary slowly.
#include <cstdint>
#include <vector>

#include "image/image_buffer.h"
#include "image/image_view.h"

namespace ninedot {

/// Threshold of every second pixel in both directions; 0 where the contrast is too low for a spot.
/// Memory: the constructor's. Threads: one caller.
class SpotThreshold {
 public:
  /// Side of the closing's square in pixels of the half-size picture: spots up to twice that many pixels of the full
  /// one. P9 is twice as wide as the ring's dots and the next level halves it: of 24 px one level sees the ring's dots
  /// and P9 together from 2.6 px on, the least that is found, with a factor of 4 to spare for tilt and blur.
  static constexpr int kSquare_px = 12;
  /// Ink is the darkest pixel of the half-size picture within this many of its pixels. A blurred small dot is paler
  /// than the large one beside it, whose ink must not be taken for its own; and no edge that is seen at this level is
  /// wider.
  static constexpr int kInkReach_px = 3;

  /// An eighth of the paper's grey level is the least contrast. Ink on paper has four times as much, and keeps that
  /// through half a veil of haze; stone, wood and plaster have less.
  static constexpr int kMinContrastShare = 8;
  /// Where nothing in the picture is dark, as behind a thick veil or a reflection, all but a sixth of the way down
  /// from the paper to the picture's darkest place is enough: ink goes nearly all of it, a wall's grain seldom. [1]
  static constexpr int kMaxRangeLeft = 6;

  SpotThreshold(int max_half_width_px, int max_half_height_px);

  /// \param half  the picture at half its size
  /// \param min_contrast_lsb  between paper and ink, grey levels; where the paper is bright, the less of both shares
  /// asks more \return  threshold picture of the size of `half`, valid until the next call
  const ImageBuffer& compute(const ImageView& half, int min_contrast_lsb) noexcept;

 private:
  ImageBuffer scratch_, dilated_, closed_, eroded_;
  ImageBuffer fours_, line_[2];
};

}  // namespace ninedot
