#include "pose/tone.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace ninedot {
namespace {

constexpr double kWhite_lsb = 255;
constexpr std::size_t kGreyLevels = 256;
constexpr double kBeside = 0.35;  // the shares at which the bend is exact: a half, and so much less and more

double light_of(double grey_lsb) noexcept {
  const double grey = std::clamp(grey_lsb / kWhite_lsb, 0.0, 1.0);
  return grey <= 0.04045 ? grey / 12.92 : std::pow((grey + 0.055) / 1.055, 2.4);
}

double grey_of(double light) noexcept {
  return kWhite_lsb * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

const std::array<float, kGreyLevels> kLight = [] {
  std::array<float, kGreyLevels> light{};
  for (std::size_t grey = 0; grey < kGreyLevels; ++grey)
    light[grey] = static_cast<float>(light_of(static_cast<double>(grey)));
  return light;
}();

}  // namespace

ToneBend srgb_bend(double paper_lsb, double contrast_lsb) noexcept {
  const double paper = light_of(paper_lsb), ink = light_of(paper_lsb - contrast_lsb);
  const double brightest_lsb = grey_of(paper), range_lsb = brightest_lsb - grey_of(ink);
  if (!(range_lsb > 0)) return {};
  const auto bend_at = [&](double s) {
    return ((brightest_lsb - grey_of(paper + s * (ink - paper))) / range_lsb - s) / (s * (1 - s));
  };
  const double less = bend_at(0.5 - kBeside), half = bend_at(0.5), more = bend_at(0.5 + kBeside);
  const double slope = (more - less) / (2 * kBeside), bend = (more - 2 * half + less) / (2 * kBeside * kBeside);
  return {static_cast<float>(half - 0.5 * slope + 0.25 * bend), static_cast<float>(slope - bend),
          static_cast<float>(bend)};
}

void straighten_tone(std::span<float> luma_lsb) noexcept {
  std::array<std::uint32_t, kGreyLevels> count{};
  for (const float grey : luma_lsb) ++count[static_cast<std::size_t>(grey)];
  // Most of what is about a landmark's dots is paper, and little is brighter.
  std::size_t paper = kGreyLevels - 1;
  for (std::uint32_t brighter = count[paper]; paper > 1 && brighter < luma_lsb.size() / 4; brighter += count[paper])
    --paper;
  const double paper_lsb = static_cast<double>(paper);
  const double per_lsb = 0.5 * (light_of(paper_lsb + 1) - light_of(paper_lsb - 1));
  const auto lsb_per_light = static_cast<float>(1 / per_lsb);
  const auto at_paper = static_cast<float>(paper_lsb);
  for (float& luma : luma_lsb)
    luma = at_paper + (kLight[static_cast<std::size_t>(luma)] - kLight[paper]) * lsb_per_light;
}

}  // namespace ninedot
