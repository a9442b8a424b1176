// How wrong the head may be without the loop swinging up: the gain and delay margins that docs/pan-tilt.md states.
//
// The linear loop: small angles, no limits, no dead band. The head stands at s c(t - d), the controller believes
// c(t - D); the sight is of the target as the belief has it, z = c(t - D) + (0 - s c(t - d)), and the filter foretells
// it by the delays of camera and head. Right where D = d and s = 1 the loop is open: whatever is commanded, z stays 0.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <vector>

#include "aim/target_motion.h"

namespace ninedot {
namespace {

struct Loop {
  double rate_hz = 35, camera_s = 0.02, head_s = 0.02;  // as configured
  double true_head_s = 0.02, scale = 1;
  double memory_s() const {  // what the controller takes for the gain 0.5
    return std::max(2 / 35.0 / std::log(2.0), camera_s + head_s + 1 / rate_hz);
  }
};

constexpr double kTick_s = 0.01;

double command_at(const std::vector<double>& commands, double t_s) {
  if (t_s < 0) return 0;
  const auto before = static_cast<std::size_t>(t_s / kTick_s);
  if (before + 1 >= commands.size()) return commands.empty() ? 0 : commands.back();
  return commands[before] + (t_s / kTick_s - static_cast<double>(before)) * (commands[before + 1] - commands[before]);
}

MonoTime time(double t_s) { return MonoTime(std::chrono::nanoseconds(100'000'000'000 + std::llround(t_s * 1e9))); }

/// Shaken for half a second, then left alone for 40 s: whether it calms down.
bool is_stable(const Loop& loop) {
  TargetMotion motion;
  std::vector<double> commands;
  std::deque<double> on_their_way;
  double exposed_s = 0, early = 0, late = 0;
  for (int k = 0; k < 4000; ++k) {
    const double t_s = k * kTick_s;
    for (; exposed_s <= t_s; exposed_s += 1 / loop.rate_hz) on_their_way.push_back(exposed_s);
    for (; !on_their_way.empty() && on_their_way.front() + loop.camera_s <= t_s + 1e-9; on_their_way.pop_front()) {
      const double e_s = on_their_way.front(), shake = e_s < 0.5 ? 0.01 * std::sin(40 * e_s) : 0;
      const double z =
          command_at(commands, e_s - loop.head_s) - loop.scale * command_at(commands, e_s - loop.true_head_s);
      motion.add(time(e_s), Eigen::Vector3d(0, z + shake, 0), std::chrono::duration<double>(loop.memory_s()));
    }
    commands.push_back(motion.is_known() ? motion.at(time(t_s + loop.head_s)).y() : 0);
    const double size = std::abs(commands.back());
    if (size > 1e6) return false;
    if (t_s > 5 && t_s < 10) early = std::max(early, size);
    if (t_s > 35) late = std::max(late, size);
  }
  return late < early || late < 1e-12;
}

// As the table of docs/pan-tilt.md has them.
struct Margin {
  double rate_hz, camera_ms, head_ms;
  double most_scale;  // from 0 on
  double least_head_ms, most_head_ms;
};
constexpr Margin kMargins[] = {
    {10, 20, 20, 2.2, 0, 86},    {35, 20, 20, 2.4, 0, 70},     {120, 20, 20, 2.7, 0, 72},  {10, 30, 120, 2.2, 50, 178},
    {35, 30, 120, 1.9, 46, 225}, {120, 30, 120, 1.9, 54, 196}, {35, 120, 30, 1.9, 0, 135},
};

Loop loop_of(const Margin& margin) {
  return {margin.rate_hz, margin.camera_ms * 1e-3, margin.head_ms * 1e-3, margin.head_ms * 1e-3, 1};
}

TEST(LoopMargins, HoldAsTheDocumentStatesThem) {
  for (const Margin& margin : kMargins) {
    for (const double part : {0.02, 0.25, 0.5, 0.75, 1.0}) {
      Loop scaled = loop_of(margin);
      scaled.scale = part * margin.most_scale;
      EXPECT_TRUE(is_stable(scaled)) << margin.rate_hz << " Hz, scale " << scaled.scale;
      Loop delayed = loop_of(margin);
      delayed.true_head_s = (margin.least_head_ms + part * (margin.most_head_ms - margin.least_head_ms)) * 1e-3;
      EXPECT_TRUE(is_stable(delayed)) << margin.rate_hz << " Hz, head " << delayed.true_head_s << " s";
    }
  }
}

TEST(LoopMargins, EndNearWhereTheDocumentSays) {
  for (const Margin& margin : kMargins) {
    Loop scaled = loop_of(margin);
    scaled.scale = 1.15 * margin.most_scale;
    EXPECT_FALSE(is_stable(scaled)) << margin.rate_hz << " Hz, scale " << scaled.scale;
    scaled.scale = -0.05;
    EXPECT_FALSE(is_stable(scaled)) << "a head that turns the wrong way";
    Loop late = loop_of(margin);
    late.true_head_s = 1.15 * margin.most_head_ms * 1e-3;
    EXPECT_FALSE(is_stable(late)) << margin.rate_hz << " Hz, head " << late.true_head_s << " s";
    if (margin.least_head_ms == 0) continue;
    Loop early = loop_of(margin);
    early.true_head_s = 0.85 * margin.least_head_ms * 1e-3;
    EXPECT_FALSE(is_stable(early)) << margin.rate_hz << " Hz, head " << early.true_head_s << " s";
  }
}

}  // namespace
}  // namespace ninedot
