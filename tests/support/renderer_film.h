#pragma once
/// From light in the cells of a picture to light in its pixels.
///
/// The point spread and the pixel's square act on sub-samples directly: per axis, the weight of a sample at d px from a
/// pixel's centre is Phi((d + 1/2) / s) - Phi((d - 1/2) / s).
#include <cstddef>
#include <span>
#include <vector>

#include "tests/support/renderer.h"

namespace ninedot::test {

/// Point spread and pixel square along one axis: weights of the samples of a cell for the pixels around it.
class Spread {
 public:
  /// \param sigma_px  of the point spread \param samples  of a cell, along the axis
  Spread(double sigma_px, int samples);
  int samples() const { return samples_; }
  int reach() const { return reach_; }  ///< [px] light of a cell comes to the pixels -reach..reach away
  double weight(int pixel, int sample) const { return weights_[index(pixel, sample)]; }

 private:
  std::size_t index(int pixel, int sample) const {
    return static_cast<std::size_t>((pixel + reach_) * samples_ + sample);
  }
  int samples_, reach_;
  std::vector<double> weights_;
};

/// Collects cells into pixels. The spread must outlive it.
class Film {
 public:
  Film(int width_px, int height_px, const Spread& spread);

  /// \param samples  row by row, of the cell of pixel (x, y), which may lie outside of the picture
  void add(int x, int y, std::span<const double> samples);

  /// Cells of one value each, a margin of the spread's reach included, all at once: the same sums, taken apart by axis.
  void add_flat(const std::vector<double>& cells);

  Exposure take() { return std::move(exposure_); }

 private:
  const Spread& spread_;
  Exposure exposure_;
  std::vector<double> column_;
};

}  // namespace ninedot::test
