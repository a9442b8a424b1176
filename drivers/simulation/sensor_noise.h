#pragma once
/// From light to grey levels, and the sensor's noise on them.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ninedot {

/// The tone curve of sRGB (IEC 61966-2-1), as most cameras have it or one near to it.
/// Memory: allocated by the constructor. Threads: never changed afterwards.
class ToneCurve {
 public:
  ToneCurve();
  /// \param light  linear, 1 saturates [1] \return  grey level in 1/256 LSB, 0..65280
  std::uint16_t grey_256th(float light) const noexcept {
    const float at = light * static_cast<float>(kSteps);
    return table_[at > 0 ? (at < static_cast<float>(kSteps) ? static_cast<std::size_t>(at) : kSteps - 1) : 0];
  }

 private:
  static constexpr std::size_t kSteps = 1U << 14U;  // 0.05 LSB where the curve is steepest for anything printed
  std::vector<std::uint16_t> table_;
};

/// Noise whose variance in light is a L + b, 85 % of it shot noise at grey level 128. The same seed gives the same
/// noise. Memory: allocated by the constructor. Threads: never changed afterwards.
class SensorNoise {
 public:
  /// \param sigma_lsb  1-sigma at grey level 128
  SensorNoise(double sigma_lsb, std::uint64_t seed);

  /// One row of pixels. \param clean  grey levels in 1/256 LSB \param noisy  as many [LSB]
  /// \param row_number  of all rows of all frames: another one, other noise
  void read_out(std::span<const std::uint16_t> clean, std::uint64_t row_number, std::uint8_t* noisy) const noexcept;

 private:
  static constexpr std::size_t kSamples = 1U << 16U;
  std::uint64_t seed_;
  std::vector<std::int16_t> samples_;            // normal, 1-sigma = 256; as many more as a row may be long
  std::array<std::int32_t, 256> sigma_256th_{};  // by grey level, in 1/256 LSB
};

}  // namespace ninedot
