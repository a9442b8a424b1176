#include "image/noise.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace ninedot {
namespace {

constexpr double kSigmaPerMedian = 1.4826;       // of |normal deviates|: 1 / the normal quantile of 3/4
constexpr double kSecondDifferenceVariance = 6;  // 1 + 2^2 + 1 times the pixels'
// A sixteenth of all pixels, 6000 of a window of 400 x 250: their median has a standard error of 2 %. Rows that far
// apart and every other pixel are differences that share no more than one pixel with the next.
constexpr int kRowStep = 8, kColumnStep = 2;
// A quarter of these is enough of a picture that has so many, in every frame: the median has a standard error of 2 %.
constexpr int kSparseRowStep = 16, kSparseColumnStep = 4;
constexpr int kSparseFrom_px2 = 150'000;
// Differences of one brightness below which their median says less than the whole picture's: a standard error of 11 %.
constexpr std::uint32_t kLeastOfClass = 100;

/// |a - 2 b + c| of bytes is at most 2 * 255.
constexpr std::size_t kBins = 512;
using DifferenceHistogram = std::array<std::uint32_t, kBins>;
/// Of each of so many equal parts of the grey levels.
template <std::size_t kParts>
using Histograms = std::array<DifferenceHistogram, kParts>;

constexpr std::size_t kTogether = 32;
using FourPixels = std::array<std::uint32_t, kTogether>;

/// Counts |a - 2 b + c| of three neighbours, the first of each four pixels, by the grey level b. Four pixels are read
/// as one word: all but the counting becomes vector instructions.
template <std::size_t kParts>
void count_differences(const FourPixels& pixels, std::size_t count, Histograms<kParts>& histograms) noexcept {
  static_assert(std::endian::native == std::endian::little);
  FourPixels cells;
  for (std::size_t i = 0; i < kTogether; ++i) {
    const auto byte = [&](int number) { return static_cast<std::int32_t>(pixels[i] >> 8 * number & 0xFF); };
    const std::int32_t difference = byte(0) - 2 * byte(1) + byte(2);
    const std::int32_t part = byte(1) / static_cast<std::int32_t>(256 / kParts);
    cells[i] = static_cast<std::uint32_t>(part * static_cast<std::int32_t>(kBins) + std::abs(difference));
  }
  std::uint32_t* const counts = histograms[0].data();  // all of them in one row
  if (count < kTogether) {
    for (std::size_t i = 0; i < count; ++i) ++counts[cells[i]];
    return;
  }
  // Usually all of them: four to a turn of the loop, which is most of the cost.
  for (std::size_t i = 0; i < kTogether; i += 4)
    ++counts[cells[i]], ++counts[cells[i + 1]], ++counts[cells[i + 2]], ++counts[cells[i + 3]];
}

/// At every fourth pixel of a row, from `x` on.
template <std::size_t kParts>
void sample_row(const std::uint8_t* row, int x, int width, Histograms<kParts>& histograms) noexcept {
  FourPixels pixels;
  std::size_t left = static_cast<std::size_t>(std::max(width - x, 0)) / 4;
  for (row += x; left >= kTogether; left -= kTogether, row += sizeof(pixels)) {
    std::memcpy(pixels.data(), row, sizeof(pixels));
    count_differences(pixels, kTogether, histograms);
  }
  if (left == 0) return;
  pixels.fill(0);
  std::memcpy(pixels.data(), row, 4 * left);
  count_differences(pixels, left, histograms);
}

/// Of every row_step-th row and every column_step-th column, which is 2 or 4.
template <std::size_t kParts>
Histograms<kParts> sampled(const ImageView& in, int row_step, int column_step) noexcept {
  Histograms<kParts> histograms{};
  for (int y = kRowStep / 2; y < in.height_px; y += row_step)
    for (int first = 0; first < 4; first += column_step) sample_row(in.row(y), first, in.width_px, histograms);
  return histograms;
}

std::uint32_t total_of(const DifferenceHistogram& histogram) noexcept {
  std::uint32_t total = 0;
  for (const std::uint32_t here : histogram) total += here;
  return total;
}

/// Second differences are whole numbers: a plain median of them would step by 0.6 grey levels, so interpolate in its
/// bin.
double sigma_of(const DifferenceHistogram& histogram) noexcept {
  const std::uint32_t count = total_of(histogram);
  double below = 0;
  for (std::size_t value = 0; value < histogram.size(); ++value) {
    const double here = histogram[value];
    if (below + here >= 0.5 * count) {
      const double median = static_cast<double>(value) - 0.5 + (here > 0 ? (0.5 * count - below) / here : 0.5);
      return kSigmaPerMedian * std::max(median, 0.0) / std::sqrt(kSecondDifferenceVariance);
    }
    below += here;
  }
  return 0;
}

}  // namespace

double estimate_noise_lsb(const ImageView& in) noexcept {
  const bool is_large = in.width_px * in.height_px >= kSparseFrom_px2;
  return sigma_of(is_large ? sampled<1>(in, kSparseRowStep, kSparseColumnStep)[0]
                           : sampled<1>(in, kRowStep, kColumnStep)[0]);
}

PictureNoise::PictureNoise(const ImageView& in) noexcept {
  const Histograms<kClasses> histograms = sampled<kClasses>(in, kSparseRowStep, kSparseColumnStep);
  DifferenceHistogram all{};
  for (const DifferenceHistogram& histogram : histograms)
    for (std::size_t value = 0; value < kBins; ++value) all[value] += histogram[value];
  overall_lsb_ = sigma_of(all);
  for (std::size_t i = 0; i < kClasses; ++i)
    class_lsb_[i] = total_of(histograms[i]) < kLeastOfClass ? overall_lsb_ : sigma_of(histograms[i]);
}

double PictureNoise::at(double grey_lsb) const noexcept {
  // Every comparison with what is not a number is false: such a grey level is the darkest.
  const double last = static_cast<double>(kClasses - 1), wanted = grey_lsb * kClasses / 256;
  const double index = wanted > 0 ? std::min(wanted, last) : 0;
  return class_lsb_[static_cast<std::size_t>(index)];
}

}  // namespace ninedot
