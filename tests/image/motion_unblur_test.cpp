#include "image/motion_unblur.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "tests/support/allocation_counter.h"

namespace ninedot {
namespace {

constexpr int kWidth_px = 320, kHeight_px = 200;

constexpr int kApart_px = 12, kPeriod_px = 60;

/// Rows of three dark dots, as a ring's middle row has them, each drawn along a line. \param line_at  of a column
template <typename LineAt>
std::vector<std::uint8_t> dots(LineAt&& line_at, double noise_lsb) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, noise_lsb);
  std::vector<std::uint8_t> pixels;
  for (int v = 0; v < kHeight_px; ++v)
    for (int u = 0; u < kWidth_px; ++u) {
      const MotionUnblur::Line line = line_at(u);
      double ink = 0;
      constexpr int kParts = 41;
      for (int part = 0; part < kParts; ++part) {
        const double t = (part + 0.5) / kParts - 0.5;
        const double x = std::remainder(u - t * line.x_px, kPeriod_px), y = std::remainder(v - t * line.y_px, 20);
        for (const int dot : {-kApart_px, 0, kApart_px})
          ink += std::clamp(2.5 - std::hypot(x - dot, y), 0.0, 1.0) / kParts;
      }
      pixels.push_back(static_cast<std::uint8_t>(std::clamp(200 - 120 * ink + noise(random), 0.0, 255.0)));
    }
  return pixels;
}

ImageView view_of(const std::vector<std::uint8_t>& pixels) { return {pixels.data(), kWidth_px, kHeight_px, kWidth_px}; }

/// How much lighter it is between two dots of a row than in them. \param first_px, end_px  columns
double apart_lsb(const ImageView& view, int first_px, int end_px) {
  double between = 0, in = 0;
  int count = 0;
  for (int v = 60; v < kHeight_px - 50; v += 20)
    for (int u = (first_px / kPeriod_px + 1) * kPeriod_px; u < end_px; u += kPeriod_px, ++count)
      in += view.at(u, v), between += 0.5 * (view.at(u + kApart_px / 2, v) + view.at(u - kApart_px / 2, v));
  return (between - in) / count;
}

/// Root mean square of the difference, but for what is near the border.
double off_lsb(const ImageView& view, const ImageView& truth) {
  double sum = 0;
  int count = 0;
  for (int v = 50; v < kHeight_px - 50; ++v)
    for (int u = 50; u < kWidth_px - 50; ++u, ++count) sum += std::pow(view.at(u, v) - truth.at(u, v), 2);
  return std::sqrt(sum / count);
}

TEST(MotionUnblur, TakesDotsApartThatMotionHasMadeOneBar) {
  for (const MotionUnblur::Line line : {MotionUnblur::Line{9, 0}, {8.5F, 3}, {-8.5F, 2}, {2, 9.5F}}) {
    const std::vector<std::uint8_t> smeared = dots([&](int) { return line; }, 1.5);
    std::array<MotionUnblur::Line, MotionUnblur::kStrips> lines;
    lines.fill(line);
    MotionUnblur unblur(kWidth_px, kHeight_px);
    const test::AllocationGuard guard;
    const ImageView out = unblur.of(view_of(smeared), lines);
    EXPECT_EQ(guard.allocations(), 0U);
    const double before_lsb = apart_lsb(view_of(smeared), 0, 300), after_lsb = apart_lsb(out, 0, 300);
    EXPECT_GT(after_lsb, 60) << line.x_px << ", " << line.y_px;
    EXPECT_GT(after_lsb, 1.5 * before_lsb) << line.x_px << ", " << line.y_px;
  }
}

TEST(MotionUnblur, GoesAlongTheLineWhereverItPoints) {
  const std::vector<std::uint8_t> sharp = dots([](int) { return MotionUnblur::Line{}; }, 0);
  for (const MotionUnblur::Line line : {MotionUnblur::Line{9, 0}, {8.5F, 3}, {7, 6}, {7, -6}, {-4, 8}, {0, 9}}) {
    const std::vector<std::uint8_t> smeared = dots([&](int) { return line; }, 1.5);
    std::array<MotionUnblur::Line, MotionUnblur::kStrips> lines;
    lines.fill(line);
    MotionUnblur unblur(kWidth_px, kHeight_px);
    EXPECT_LT(off_lsb(unblur.of(view_of(smeared), lines), view_of(sharp)),
              0.8 * off_lsb(view_of(smeared), view_of(sharp)))
        << line.x_px << ", " << line.y_px;
  }
}

TEST(MotionUnblur, TakesEachStripByItsOwnLine) {
  const auto line_at = [](int u) { return MotionUnblur::Line{6 + 3.5F * static_cast<float>(u) / kWidth_px, 0}; };
  const std::vector<std::uint8_t> smeared = dots(line_at, 1.5);
  std::array<MotionUnblur::Line, MotionUnblur::kStrips> lines, same;
  for (std::size_t s = 0; s < lines.size(); ++s)
    lines[s] = line_at((2 * static_cast<int>(s) + 1) * kWidth_px / (2 * static_cast<int>(lines.size())));
  same.fill(line_at(0));
  MotionUnblur unblur(kWidth_px, kHeight_px);
  const double by_own_lsb = apart_lsb(unblur.of(view_of(smeared), lines), 200, 310);
  EXPECT_GT(by_own_lsb, 60);
  EXPECT_LT(apart_lsb(unblur.of(view_of(smeared), same), 200, 310), 0.8 * by_own_lsb);
}

TEST(MotionUnblur, LeavesWhatIsNotSmearedOrFarTooMuch) {
  const std::vector<std::uint8_t> picture = dots([](int) { return MotionUnblur::Line{}; }, 1.5);
  MotionUnblur unblur(kWidth_px, kHeight_px);
  for (const MotionUnblur::Line line : {MotionUnblur::Line{}, {0.5F, 0.5F}, {40, 0}, {0, -400}}) {
    std::array<MotionUnblur::Line, MotionUnblur::kStrips> lines;
    lines.fill(line);
    ImageView in = view_of(picture);
    in.has_pattern = true;
    const ImageView out = unblur.of(in, lines);
    EXPECT_TRUE(out.has_pattern);
    for (int v = 0; v < kHeight_px; ++v)
      ASSERT_TRUE(std::equal(out.row(v), out.row(v) + kWidth_px, in.row(v))) << line.x_px << ", row " << v;
  }
}

TEST(MotionUnblur, KeepsEvenLightAsItIsUpToTheBorder) {
  const std::vector<std::uint8_t> even(kWidth_px * kHeight_px, 77);
  MotionUnblur unblur(kWidth_px, kHeight_px);
  std::array<MotionUnblur::Line, MotionUnblur::kStrips> lines;
  lines.fill({10, -7});
  const ImageView out = unblur.of(view_of(even), lines);
  for (int v = 0; v < kHeight_px; ++v)
    for (int u = 0; u < kWidth_px; ++u) ASSERT_EQ(out.at(u, v), 77) << u << ", " << v;
}

}  // namespace
}  // namespace ninedot
