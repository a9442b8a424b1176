#include "image/picture_shift.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "base/vector_clones.h"

namespace ninedot {
namespace {

constexpr int kBin_px = 2;       // smeared profiles have nothing finer
constexpr double kMost = 0.4;    // of the picture
constexpr std::size_t kRim = 2;  // bins at a profile's ends, where it has no slope
// Of two profiles that are alike: 1 the same, 0 nothing in common. Pictures of one room that a camera turned through at
// 140 degrees a second, smeared by 10 px, had 0.54 at least; the next best shift of theirs up to 0.8 of that.
constexpr float kLeastScore = 0.4F, kClearly = 0.85F;
constexpr std::size_t kElsewhere = 8;  // bins away: no part of the same peak
constexpr std::size_t kLanes = 8;      // sums of their own: vector instructions, and the same bytes with any

NINEDOT_VECTOR_CLONES
void add_columns(const std::uint8_t* __restrict row, std::size_t width, std::uint32_t* __restrict sums) noexcept {
  for (std::size_t x = 0; x < width; ++x) sums[x] += row[x];
}

NINEDOT_VECTOR_CLONES
std::uint32_t sum_of(const std::uint8_t* row, std::size_t count) noexcept {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += row[i];
  return sum;
}

NINEDOT_VECTOR_CLONES
float product(const float* a, const float* b, std::size_t count) noexcept {
  std::array<float, kLanes> lanes{};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (std::size_t l = 0; l < kLanes; ++l) lanes[l] += a[i + l] * b[i + l];
  float sum = 0;
  for (const float lane : lanes) sum += lane;
  for (; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

PictureShift::PictureShift(int width_px, int height_px) : width_px_(width_px), height_px_(height_px) {
  const auto bins = [](int length_px) { return static_cast<std::size_t>(length_px / kBin_px); };
  for (Picture* picture : {&before_, &now_})
    for (const auto& [profiles, count] :
         {std::pair{&picture->along_x, bins(width_px)}, std::pair{&picture->along_y, bins(height_px)}})
      for (std::size_t band = 0; band <= kBands; ++band) {
        profiles->slopes[band].resize(count);
        profiles->energy[band].resize(count + 1);
      }
  const auto longest = static_cast<std::size_t>(std::max(width_px, height_px));
  sums_.resize(kBands * longest);
  scores_.resize(2 * static_cast<std::size_t>(kMost * static_cast<double>(longest) / kBin_px) + 1);
}

/// From `sums_`, which has as many places for each band. \param band_px  how many pixels each sum is of
void PictureShift::take_slopes(std::size_t band_px, Profiles& profiles) noexcept {
  std::vector<float>& of_all = profiles.slopes[kBands];
  std::ranges::fill(of_all, 0.0F);
  for (std::size_t band = 0; band <= kBands; ++band) {
    std::vector<float>&slopes = profiles.slopes[band], &energy = profiles.energy[band];
    const std::size_t count = slopes.size();
    if (band < kBands) {
      const std::uint32_t* sums = sums_.data() + band * count * kBin_px;
      const auto bin = [&](std::size_t i) { return static_cast<float>(sums[kBin_px * i] + sums[kBin_px * i + 1]); };
      for (std::size_t i = 0; i < count; ++i) {
        const bool at_rim = i < kRim || i + kRim >= count;
        slopes[i] = at_rim ? 0 : (bin(i + 1) - bin(i - 1)) / static_cast<float>(band_px);
        of_all[i] += slopes[i];
      }
    }
    for (std::size_t i = 0; i < count; ++i) energy[i + 1] = energy[i] + slopes[i] * slopes[i];
  }
}

void PictureShift::sum_up(const ImageView& luma) noexcept {
  const auto width = static_cast<std::size_t>(width_px_ / kBin_px * kBin_px),
             height = static_cast<std::size_t>(height_px_ / kBin_px * kBin_px);
  std::ranges::fill(sums_, 0U);
  for (std::size_t y = 0; y < height; ++y)
    add_columns(luma.row(static_cast<int>(y)), width, sums_.data() + y * kBands / height * width);
  take_slopes(height / kBands, now_.along_x);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t band = 0; band < kBands; ++band)
      sums_[band * height + y] = sum_of(luma.row(static_cast<int>(y)) + band * (width / kBands), width / kBands);
  take_slopes(width / kBands, now_.along_y);
}

/// By the bands, of which each has its own to tell; where the picture has moved by as much across them, by all of it.
std::optional<double> PictureShift::shift_px(const Profiles& before, const Profiles& now) noexcept {
  const auto by_bands = best_shift_px(before, now, 0, kBands);
  return by_bands ? by_bands : best_shift_px(before, now, kBands, kBands + 1);
}

std::optional<double> PictureShift::best_shift_px(const Profiles& before, const Profiles& now, std::size_t first_band,
                                                  std::size_t end_band) noexcept {
  const std::size_t count = now.slopes[0].size();
  const auto most = static_cast<std::size_t>(kMost * static_cast<double>(count));
  for (std::size_t k = 0; k <= 2 * most; ++k) {
    // By k - most bins: what was at `from` is at `to`.
    const std::size_t from = k < most ? most - k : 0, to = k < most ? 0 : k - most, length = count - std::max(from, to);
    float both = 0, of_before = 0, of_now = 0;
    for (std::size_t band = first_band; band < end_band; ++band) {
      both += product(before.slopes[band].data() + from, now.slopes[band].data() + to, length);
      of_before += before.energy[band][from + length] - before.energy[band][from];
      of_now += now.energy[band][to + length] - now.energy[band][to];
    }
    const float scale = of_before * of_now;
    scores_[k] = scale > 0 ? both / std::sqrt(scale) : 0;
  }
  const std::span<const float> scores(scores_.data(), 2 * most + 1);
  const auto best = static_cast<std::size_t>(std::ranges::max_element(scores) - scores.begin());
  if (!(scores[best] > kLeastScore) || best == 0 || best == 2 * most) return std::nullopt;
  for (std::size_t k = 0; k < scores.size(); ++k)
    if ((k + kElsewhere < best || k > best + kElsewhere) && scores[k] > kClearly * scores[best]) return std::nullopt;
  const float bend = scores[best - 1] - 2 * scores[best] + scores[best + 1];
  const float beside = bend < 0 ? 0.5F * (scores[best - 1] - scores[best + 1]) / bend : 0;
  return kBin_px * (static_cast<double>(best) - static_cast<double>(most) + beside);
}

std::optional<ShiftedBy> PictureShift::to(const ImageView& luma) noexcept {
  std::swap(before_, now_);
  sum_up(luma);
  if (!std::exchange(has_before_, true)) return std::nullopt;
  const auto x_px = shift_px(before_.along_x, now_.along_x), y_px = shift_px(before_.along_y, now_.along_y);
  if (!x_px || !y_px) return std::nullopt;
  return ShiftedBy{*x_px, *y_px};
}

}  // namespace ninedot
