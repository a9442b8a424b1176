#pragma once
/// Places on the outlines of dots, measured in the grey levels across them to a hundredth of a pixel.
///
/// Every outline is cut into stretches. The pixels of a stretch see ink, paper and between them a step that the point
/// spread has blurred: g = ink + (paper - ink) Phi((d - shift) / blur), d the pixel's distance from where the outline
/// is expected. Ink, paper and shift are fitted to each stretch by itself, so light may change over the sheet as it
/// likes; the blur to all of the view's.
#include <span>
#include <vector>

#include "calibrate_camera/sheet_map.h"
#include "calibrate_camera/sheet_view.h"

namespace ninedot {

/// Where a disc's outline is expected, to about two pixels.
struct ExpectedDisc {
  std::size_t disc = 0;  ///< index of it
  SheetMap map;
};

/// \param view  its picture and noise are read
/// \param expected  discs that may be cut by the picture's border: what is inside counts
/// \param discs  of the sheet
/// \return  of the stretches that are wholly in the picture and look like an outline: contrast well above the noise,
/// and no more beside the step than twice the noise and a part of the contrast leave Memory: allocates. Threads: pure.
std::vector<EdgePoint> measure_edges(const SheetView& view, std::span<const ExpectedDisc> expected,
                                     std::span<const PlaneDisc> discs);

}  // namespace ninedot
