#include "pose/smeared_ink.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "pose/blurred_disc.h"
#include "pose/outline_sums.h"

namespace ninedot {
namespace {

constexpr float kContrast_lsb = 90;

/// A sheet 4.5 m away, and a camera that turns to the side by 11 px while it exposes.
class SmearedInk : public testing::Test {
 protected:
  SmearedInk() : rays_(camera_) {
    state_.T_camera_landmark.rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;
    state_.T_camera_landmark.translation_m = {0.1, -0.05, 4.5};
    state_.blur_px2 = 0.8 + 11 * 11 / 24.0, state_.blur_cos_px2 = 11 * 11 / 24.0;
    contrasts_lsb_.fill(kContrast_lsb);
    look();
    for (int y = 0; y < camera_.height_px; ++y)
      for (int x = 0; x < camera_.width_px; ++x)
        grey_[static_cast<std::size_t>(y * camera_.width_px + x)] =
            static_cast<std::uint8_t>(std::lround(200 - kContrast_lsb * share_of_all(x, y)));
    look();
  }
  void look() {
    collect_outline_pixels({grey_.data(), camera_.width_px, camera_.height_px, camera_.width_px}, camera_, rays_, {},
                           state_.T_camera_landmark, 8, 1, {}, {}, pixels_);
  }
  float share_of(std::size_t dot, int x, int y) const {
    const BlurredDisc disc(pixels_, {}, state_, dot, Asked::kLightOnly);
    EXPECT_TRUE(disc.is_small());
    const Eigen::Vector2d ray = camera_.normalised_from_pixel({x, y}).value();
    Lanes ray_x, ray_y, share;
    ray_x.fill(static_cast<float>(ray.x())), ray_y.fill(static_cast<float>(ray.y()));
    disc.ink_share(ray_x, ray_y, share);
    return share[0];
  }
  float share_of_all(int x, int y) const {
    if (std::abs(x - camera_.cx_px) > 60 || std::abs(y - camera_.cy_px) > 60) return 0;
    float sum = 0;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) sum += share_of(dot, x, y);
    return sum;
  }
  /// Of each dot, by a fit.
  std::array<double, kDotCount> contrasts() {
    GroupFitter fitter(pixels_, landmark_, state_, Asked::kState);
    std::array<double, kDotCount> found{};
    for (const OutlineGroup& group : pixels_.groups) {
      GroupFit fit;
      fitter.fit(group, fit);
      found[group.dot] = fit.usable ? fit.contrast_lsb : 0;
    }
    return found;
  }

  CameraModel camera_{};
  LandmarkGeometry landmark_;
  RayTable rays_;
  OutlineState state_;
  DotContrasts contrasts_lsb_;
  OutlinePixels pixels_{12000};
  std::vector<std::uint8_t> grey_ = std::vector<std::uint8_t>(640 * 480, 200);
};

TEST_F(SmearedInk, IsThatOfTheOtherDotsInEachPixel) {
  gather_ink_of_others(landmark_, state_, contrasts_lsb_, pixels_);
  float most = 0;
  for (const OutlineGroup& group : pixels_.groups)
    for (int i = group.first; i < group.first + group.count; i += 7) {
      const auto at = static_cast<std::size_t>(i);
      const int x = static_cast<int>(pixels_.x_px[at]), y = static_cast<int>(pixels_.y_px[at]);
      const float others = kContrast_lsb * (share_of_all(x, y) - share_of(group.dot, x, y));
      EXPECT_NEAR(pixels_.ink_of_others_lsb[at], others, 0.3) << int{group.dot} << " at " << x << ", " << y;
      most = std::max(most, others);
    }
  EXPECT_GT(most, 10) << "they don't run into each other";
}

TEST_F(SmearedInk, PutBackLeavesEachDotItsOwn) {
  const auto worst = [&] {
    double off_lsb = 0;
    for (const double contrast : contrasts()) off_lsb = std::max(off_lsb, std::abs(contrast - kContrast_lsb));
    return off_lsb;
  };
  EXPECT_GT(worst(), 4);
  pixels_.are_smeared = true;
  gather_ink_of_others(landmark_, state_, contrasts_lsb_, pixels_);
  EXPECT_LT(worst(), 2);
}

}  // namespace
}  // namespace ninedot
