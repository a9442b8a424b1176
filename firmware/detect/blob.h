#pragma once
/// A dark, roundish blob: a candidate for a dot.
#include <Eigen/Core>

#include "base/inline_vector.h"

namespace ninedot {

/// In place of a pyramid's level: found in a part of the picture at twice its size.
inline constexpr int kEnlarged = -1;

/// One blob. Pixels of the full-size picture. The ellipse is that of the second moments, point spread included.
struct Blob {
  float x_px, y_px;  ///< centroid
  float area_px2;
  /// Second central moments divided by the area: a disc of radius r has r^2 / 4, a pixel 1/12, and nothing less.
  float xx_px2, xy_px2, yy_px2;
  int level;  ///< pyramid level that it was found at, or kEnlarged

  /// Of the outline's ellipse, point spread included; never the root of a negative number.
  float semi_major_px() const noexcept;
  Eigen::Matrix2d moments_px2() const noexcept { return Eigen::Matrix2d{{xx_px2, xy_px2}, {xy_px2, yy_px2}}; }
  bool is_finite() const noexcept;
};

/// All four levels of a room at once have 500 to more than 1000 (counted over ten recordings).
inline constexpr std::size_t kMaxBlobs = 2048;
using BlobList = InlineVector<Blob, kMaxBlobs>;

}  // namespace ninedot
