#include "pose/tone.h"

#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

constexpr double kWhite_lsb = 255;
constexpr double kBeside = 0.35;  // the shares at which the bend is exact: a half, and so much less and more

double light_of(double grey_lsb) noexcept {
  const double grey = std::clamp(grey_lsb / kWhite_lsb, 0.0, 1.0);
  return grey <= 0.04045 ? grey / 12.92 : std::pow((grey + 0.055) / 1.055, 2.4);
}

double grey_of(double light) noexcept {
  return kWhite_lsb * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

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

}  // namespace ninedot
