#pragma once
/// Area, centroid and second moments of what may be a dot.
#include "detect/region_finder.h"
#include "image/image_view.h"

namespace ninedot {

/// In the pixels of the picture that it was measured in, pixel centres at integers.
struct Moments {
  double area_px2 = 0;
  double x_px = 0, y_px = 0;                  ///< centroid
  double xx_px2 = 0, xy_px2 = 0, yy_px2 = 0;  ///< central, divided by the area
};

/// The least variance in any direction: that of one pixel, a square of uniform weight, E[x^2] over (-1/2, 1/2) = 1/12.
/// What has less was not seen through pixels.
inline constexpr double kPixelVariance_px2 = 1.0 / 12;

/// Of the region's pixels, each one a square. Memory: none. Threads: pure.
Moments outline_moments(const Region& region) noexcept;

/// Weighted by darkness, over the region's box and two pixels around it; the paper's level is the mean of the box's
/// rim. No variance is below kPixelVariance_px2 in any direction.
/// \param picture  at least 3 x 3 pixels, the region's box inside it and no longer than 60 px (contract)
/// \param noise_lsb  of `picture` [grey levels, 1-sigma]
/// \return  false: nothing there is darker than the rim
/// Memory: none. Threads: pure.
bool measure_darkness(const ImageView& picture, const Region& region, double noise_lsb, Moments& m) noexcept;

/// Moments of a region that may be a dot: by its darkness where it is small and nothing else reaches into its box, else
/// by its outline. \param picture, noise_lsb  as above
/// \return  false: it does not fill the ellipse of its moments
/// Memory: none. Threads: pure.
bool measure_blob(const ImageView& picture, const Region& region, double noise_lsb, Moments& m) noexcept;

}  // namespace ninedot
