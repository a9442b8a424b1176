#include "image/motion_unblur.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/vector_clones.h"

namespace ninedot {
namespace {

// Noise over signal. In a rendered room of smears of 3 to 10 px, 0.003 to 0.01 found most landmarks whose smear is
// longer than 6 px; less is too noisy, with more the dots of a row stay one bar.
constexpr double kNoise = 0.01;
// What is shorter leaves dots apart, and finding them does not get better.
constexpr float kShortest_px = 1;
constexpr std::size_t kSteps = 512;  // of frequencies, from 0 to a whole turn for each pixel
constexpr double kReachPerLine = 4;  // of the filter on either side: what is beyond is less than the noise
constexpr double kTapered = 0.25;    // of it: where it fades

/// sin(pi x) / (pi x). \param turns  x
double sinc(double turns) noexcept {
  const double x = std::numbers::pi * turns;
  return std::abs(x) < 1e-6 ? 1 : std::sin(x) / x;
}

NINEDOT_VECTOR_CLONES
void add_weighted(const std::uint8_t* __restrict from, float weight, std::size_t count, float* __restrict to) noexcept {
  for (std::size_t i = 0; i < count; ++i) to[i] += weight * static_cast<float>(from[i]);
}

NINEDOT_VECTOR_CLONES
void round_to(const float* __restrict from, std::size_t count, std::uint8_t* __restrict to) noexcept {
  for (std::size_t i = 0; i < count; ++i)
    to[i] = static_cast<std::uint8_t>(static_cast<int>(std::clamp(from[i] + 0.5F, 0.0F, 255.0F)));
}

}  // namespace

MotionUnblur::MotionUnblur(int width_px, int height_px)
    : width_px_(width_px),
      height_px_(height_px),
      padded_(width_px + 2 * kReach, height_px + 2 * kReach),
      out_(width_px, height_px),
      cosines_(kSteps),
      row_(static_cast<std::size_t>(width_px)) {
  for (std::size_t i = 0; i < kSteps; ++i)
    cosines_[i] = static_cast<float>(std::cos(2 * std::numbers::pi * static_cast<double>(i) / kSteps));
}

/// The filter's answer to a point, along the line.
void MotionUnblur::set_taps(const Line& line) noexcept {
  const bool is_flat = std::abs(line.x_px) >= std::abs(line.y_px);
  const double length_px = std::abs(is_flat ? line.x_px : line.y_px);
  const double slope = is_flat ? line.y_px / line.x_px : line.x_px / line.y_px;
  const int reach = std::min(kReach, static_cast<int>(std::ceil(kReachPerLine * length_px)));
  std::array<double, kSteps / 2 + 1> gain;
  for (std::size_t k = 0; k <= kSteps / 2; ++k) {
    const double H = sinc(static_cast<double>(k) / kSteps * length_px);
    gain[k] = H * (1 + kNoise) / (H * H + kNoise);
  }
  tap_count_ = 0;
  double sum = 0;
  std::array<double, kReach + 1> answer;
  for (int i = 0; i <= reach; ++i) {
    double value = gain[0] + (i % 2 == 0 ? 1 : -1) * gain[kSteps / 2];
    for (std::size_t k = 1; k < kSteps / 2; ++k)
      value += 2 * gain[k] * cosines_[k * static_cast<std::size_t>(i) % kSteps];
    const double faded = std::clamp((reach + 1 - i) / (kTapered * (reach + 1)), 0.0, 1.0);
    answer[static_cast<std::size_t>(i)] = value / kSteps * 0.5 * (1 - std::cos(std::numbers::pi * faded));
    sum += (i == 0 ? 1 : 2) * answer[static_cast<std::size_t>(i)];
  }
  for (int i = -reach; i <= reach; ++i) {
    // Between two rows: to the nearest one, its gains make steps of what the line passes.
    const double aside = slope * i, below = std::floor(aside), share = aside - below;
    const double weight = answer[static_cast<std::size_t>(std::abs(i))] / sum;
    const auto add = [&](int aside_px, double part) {
      if (part == 0) return;
      taps_[tap_count_++] = {is_flat ? i : aside_px, is_flat ? aside_px : i, static_cast<float>(part * weight)};
    };
    add(static_cast<int>(below), 1 - share);
    add(static_cast<int>(below) + 1, share);
  }
}

void MotionUnblur::filter_strip(int first_px, int end_px) noexcept {
  const auto count = static_cast<std::size_t>(end_px - first_px);
  for (int y = 0; y < height_px_; ++y) {
    std::fill_n(row_.begin(), count, 0.0F);
    for (std::size_t t = 0; t < tap_count_; ++t)
      add_weighted(padded_.row(y + kReach + taps_[t].dy_px) + first_px + kReach + taps_[t].dx_px, taps_[t].weight,
                   count, row_.data());
    round_to(row_.data(), count, out_.row(y) + first_px);
  }
}

ImageView MotionUnblur::of(const ImageView& luma, const std::array<Line, kStrips>& lines) noexcept {
  for (int y = -kReach; y < height_px_ + kReach; ++y) {
    const std::uint8_t* from = luma.row(std::clamp(y, 0, height_px_ - 1));
    std::uint8_t* to = padded_.row(y + kReach);
    std::fill_n(to, kReach, from[0]);
    std::copy_n(from, width_px_, to + kReach);
    std::fill_n(to + kReach + width_px_, kReach, from[width_px_ - 1]);
  }
  for (std::size_t s = 0; s < kStrips; ++s) {
    const int first_px = width_px_ * static_cast<int>(s) / static_cast<int>(kStrips),
              end_px = width_px_ * static_cast<int>(s + 1) / static_cast<int>(kStrips);
    const float length_px = std::max(std::abs(lines[s].x_px), std::abs(lines[s].y_px));
    if (length_px >= kShortest_px && length_px <= kLongest_px) {
      set_taps(lines[s]);
      filter_strip(first_px, end_px);
    } else {
      for (int y = 0; y < height_px_; ++y)
        std::copy_n(luma.row(y) + first_px, end_px - first_px, out_.row(y) + first_px);
    }
  }
  ImageView view = out_.view();
  view.has_pattern = luma.has_pattern;
  return view;
}

}  // namespace ninedot
