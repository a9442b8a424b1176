#pragma once
/// How noisy a picture is.
#include <array>
#include <cstddef>

#include "image/image_view.h"

namespace ninedot {

/// Noise of a picture, from second differences along some rows: 1.4826 median |d2| / sqrt(6). Edges hardly move it.
/// Source: Immerkaer, "Fast Noise Variance Estimation", CVIU 1996, with a median in place of the mean.
/// \return  1-sigma [grey levels]; 0 for a picture narrower than four pixels
/// Memory: none (2 kB of stack). Threads: pure.
double estimate_noise_lsb(const ImageView& in) noexcept;

/// Noise of a picture and how it grows with brightness: the same estimate, from a quarter of the pixels, for each
/// eighth of the grey levels apart.
/// Sensors of photons have more of it where it is bright, tone curves more where it is dark.
class PictureNoise {
 public:
  PictureNoise() = default;
  /// Memory: none (18 kB of stack). Threads: pure.
  explicit PictureNoise(const ImageView& in) noexcept;

  /// Of all pixels together, 1-sigma [LSB].
  double overall_lsb() const noexcept { return overall_lsb_; }
  /// Around one grey level, 1-sigma [LSB]; where the picture shows too little of it, that of all pixels.
  /// \param grey_lsb  0..255; what is outside counts as the end of the range [LSB]
  double at(double grey_lsb) const noexcept;

 private:
  static constexpr std::size_t kClasses = 8;
  std::array<double, kClasses> class_lsb_{};
  double overall_lsb_ = 0;
};

}  // namespace ninedot
