#pragma once
/// A picture without the smear of a camera that turned while it was exposed, for finding things in it: noisier, and
/// with ghosts beside what is bright. What is to be measured is measured in the picture as it was.
///
/// While a row is exposed each point draws a line of even brightness. Wiener's filter along that line (N. Wiener,
/// "Extrapolation, Interpolation, and Smoothing of Stationary Time Series", 1949) takes it back as far as the noise
/// lets: with H(f) = sinc(f L) for a line of L pixels it is H (1 + q) / (H^2 + q), where q is noise over signal. The
/// line is as long as the picture moves there, so that each strip of columns has a filter of its own.
#include <array>
#include <cstddef>
#include <vector>

#include "image/image_buffer.h"
#include "image/image_view.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one caller.
class MotionUnblur {
 public:
  static constexpr std::size_t kStrips = 8;  ///< of columns, from left to right, equally wide
  /// What a point draws while it is exposed.
  struct Line {
    float x_px = 0, y_px = 0;
  };
  static constexpr float kLongest_px = 20;  ///< along the axis that it is nearer to; what is longer stays smeared

  /// \param width_px  of all pictures \param height_px  likewise
  MotionUnblur(int width_px, int height_px);

  /// \param lines  of each strip: at its middle \return  valid until the next call
  ImageView of(const ImageView& luma, const std::array<Line, kStrips>& lines) noexcept;

 private:
  /// Pixels of the filter on either side.
  static constexpr int kReach = 80;
  struct Tap {
    int dx_px, dy_px;
    float weight;
  };
  void set_taps(const Line& line) noexcept;
  void filter_strip(int first_px, int end_px) noexcept;

  int width_px_, height_px_;
  ImageBuffer padded_;  // beyond the picture its border goes on for kReach
  ImageBuffer out_;
  std::array<Tap, 2 * (2 * kReach + 1)> taps_;  // two for each pixel of the filter
  std::size_t tap_count_ = 0;
  std::vector<float> cosines_;
  std::vector<float> row_;
};

}  // namespace ninedot
