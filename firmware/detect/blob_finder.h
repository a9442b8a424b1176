#pragma once
/// Dark, roundish blobs of every size in a picture: candidates for dots.
#include <cstdint>
#include <vector>

#include "base/inline_vector.h"
#include "image/dark_spots.h"
#include "image/image_view.h"
#include "image/pyramid.h"

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

/// Memory: the constructor's. Threads: one caller.
class BlobFinder {
 public:
  static constexpr int kLevels = 4;

  /// \param width_px, height_px  of the largest picture
  BlobFinder(int width_px, int height_px);

  /// Levels of the pyramid to look at: level i finds spots of about 2 to 20 pixels of 1/2^i of the size.
  struct Levels {
    int first = 0;
    int last = kLevels - 1;
  };

  /// \param luma  at most the constructed size (contract)
  /// \param blobs  filled; when there are more than kMaxBlobs, the smallest pictures' (largest blobs') come first
  void find_blobs(const ImageView& luma, Levels levels, BlobList& blobs) noexcept;

  /// Noise of the picture last searched [grey levels, 1-sigma].
  double noise_lsb() const noexcept { return noise_lsb_; }

  /// The picture last searched at 1 / 2^level of its size, level 1 .. the last one searched plus one.
  ImageView picture_at(int level) const noexcept { return levels_[level - 1].view(); }

 private:
  struct Run {
    std::int16_t begin, end;  // [begin, end) in its row
    std::int32_t component;   // union-find parent
  };
  struct Component {
    std::int32_t area;
    std::int32_t sum_x, sum_y;
    std::int64_t sum_xx, sum_xy, sum_yy;
    std::int16_t min_x, max_x, min_y, max_y;
  };
  void find_runs(const ImageView& picture, const ImageBuffer& threshold) noexcept;
  void label_components() noexcept;
  void collect(const ImageView& picture, int level, double noise_lsb, BlobList& blobs) const noexcept;
  std::int32_t root(std::int32_t i) noexcept;

  ImageBuffer levels_[kLevels];  // levels_[i] is the picture at 1 / 2^(i+1)
  SpotThreshold threshold_;
  std::vector<std::uint8_t> mask_;
  std::vector<Run> runs_;
  std::size_t run_count_ = 0;
  std::vector<std::int32_t> row_start_;
  std::vector<Component> components_;
  std::size_t component_count_ = 0;
  double noise_lsb_ = 0;
};

}  // namespace ninedot
