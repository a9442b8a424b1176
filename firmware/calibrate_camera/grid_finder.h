#pragma once
/// Finds a printed grid of dots (geometry/dot_grid.h), or the part of it that is in the picture.
#include <vector>

#include "calibrate_camera/sheet_finder.h"
#include "detect/blob_finder.h"
#include "geometry/dot_grid.h"

namespace ninedot {

/// From dot to dot: each foretells where its neighbours are, by the two steps that led to it, so that a lens may bend
/// the grid as it likes. The three large dots then say which is which.
class GridFinder final : public SheetFinder {
 public:
  GridFinder(int width_px, int height_px, const DotGrid& grid);
  std::vector<SeenDisc> find(const ImageView& luma) override;

 private:
  std::vector<SeenDisc> find_among_blobs() const;

  DotGrid grid_;
  BlobFinder finder_;
  BlobList blobs_;
};

}  // namespace ninedot
