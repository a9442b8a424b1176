#pragma once
/// A dark, roundish blob: a candidate for a dot.
#include "base/inline_vector.h"

namespace ninedot {

/// One blob. Pixels of the full-size picture. The ellipse is that of the second moments, point spread included.
struct Blob {
  float x_px, y_px;  ///< centroid
  float area_px2;
  float xx_px2, xy_px2, yy_px2;  ///< second central moments divided by the area: a disc of radius r has r^2 / 4
  int level;                     ///< pyramid level that it was found at
  float semi_major_px() const noexcept;
};

inline constexpr std::size_t kMaxBlobs = 1024;
using BlobList = InlineVector<Blob, kMaxBlobs>;

}  // namespace ninedot
