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

/// A view with fewer edges says nothing: five dots in the picture's corner have forty. [1]
inline constexpr std::size_t kLeastEdges = 24;
/// Steps that are blurred by more have too little plain ink and paper beside them within the pixels that are looked at.
/// Rendered and recorded pictures that are in focus have 0.5 to 1.5 px. [px]
inline constexpr double kSharp_px = 2.5;

struct MeasuredOutlines {
  std::vector<EdgePoint> edges;
  double blur_px = 0;  ///< 1-sigma of the point spread, median over the stretches
};

/// \param view  its picture and noise are read
/// \param expected  discs that may be cut by the picture's border: what is inside counts
/// \param discs  of the sheet
/// \return  of the stretches that are wholly in the picture and look like an outline: contrast well above the noise,
/// and no more beside the step than twice the noise and a part of the contrast leave
/// Memory: allocates. Threads: pure.
MeasuredOutlines measure_edges(const SheetView& view, std::span<const ExpectedDisc> expected,
                               std::span<const PlaneDisc> discs);

/// Where the discs that were found are expected before anything is known of the lens; none: fewer than five.
std::vector<ExpectedDisc> expected_by_homography(const SheetView& view, std::span<const PlaneDisc> discs);

}  // namespace ninedot
