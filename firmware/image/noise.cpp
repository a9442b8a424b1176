#include "image/noise.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

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
using DifferenceHistogram = std::array<std::uint32_t, 2 * 255 + 1>;

/// Calls count(b, |a - 2 b + c|) for the sampled triples of neighbours.
template <int kRows, int kColumns, typename Count>
void sample_differences(const ImageView& in, Count&& count) noexcept {
  for (int y = kRowStep / 2; y < in.height_px; y += kRows) {
    const std::uint8_t* row = in.row(y);
    for (int x = 1; x + 1 < in.width_px; x += kColumns)
      count(row[x], static_cast<std::size_t>(std::abs(row[x - 1] - 2 * row[x] + row[x + 1])));
  }
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
  DifferenceHistogram histogram{};
  const auto count = [&](std::uint8_t, std::size_t difference) { ++histogram[difference]; };
  if (in.width_px * in.height_px < kSparseFrom_px2)
    sample_differences<kRowStep, kColumnStep>(in, count);
  else
    sample_differences<kSparseRowStep, kSparseColumnStep>(in, count);
  return sigma_of(histogram);
}

PictureNoise::PictureNoise(const ImageView& in) noexcept {
  std::array<DifferenceHistogram, kClasses> histograms{};
  sample_differences<kSparseRowStep, kSparseColumnStep>(
      in, [&](std::uint8_t grey, std::size_t difference) { ++histograms[grey * kClasses / 256][difference]; });
  DifferenceHistogram all{};
  for (const DifferenceHistogram& histogram : histograms)
    for (std::size_t value = 0; value < all.size(); ++value) all[value] += histogram[value];
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
