// Pictures that are what the fit assumes, drawn block by block: paper, its slope, and the dots' covers.
#include "colour/sheet_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "colour/blocks.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

constexpr int kSide_px = 64;
constexpr std::array<float, kDotCount> kDrops{0.95F, 0.5F, 0.7F, 0.3F, 0.9F, 0.6F, 0.8F, 0.4F, 0.96F};

/// A camera, and a sheet whose dots it sees 2.4 px wide.
class Sheet {
 public:
  explicit Sheet(double x_m = 0.013) {
    camera_.width_px = camera_.height_px = kSide_px;
    camera_.cx_px = camera_.cy_px = (kSide_px - 1) / 2.0;
    T_.rotation =
        (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    T_.translation_m = {x_m, 0.021, camera_.fx_px * 2 * landmark.dot_radius_m / 2.4};
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      discs[dot] = disc_in_picture(T_, camera_, landmark.centre_m(dot), landmark.radius_m(dot));
    luma_.assign(kSide_px * kSide_px, 0);
    chroma_.assign(kSide_px * kSide_px / 2, 128);
  }

  /// Light of the paper in the picture's middle, and by how much of it that grows from one side to the other. [1]
  void draw(float paper, float slope = 0) {
    for (int y = 0; y < kSide_px / 2; ++y)
      for (int x = 0; x < kSide_px / 2; ++x) {
        const Eigen::Vector2f px(2 * static_cast<float>(x) + 0.5F, 2 * static_cast<float>(y) + 0.5F);
        float share = 1;
        for (std::size_t dot = 0; dot < kDotCount; ++dot)
          share -= kDrops[dot] *
                   discs[dot].cover(discs[dot].inside_px(discs[dot].radius_per_px * (px - discs[dot].centre_px)),
                                    kBlockBlur_px);
        set(x, y, share * paper * (1 + slope * (px.x() / kSide_px - 0.5F)));
      }
  }
  /// \param light  0..1, of a block
  void set(int x, int y, float light) {
    const auto grey = static_cast<std::uint8_t>(std::lround(255 * std::sqrt(std::clamp(light, 0.0F, 1.0F))));
    for (const int at : {2 * y * kSide_px + 2 * x, (2 * y + 1) * kSide_px + 2 * x})
      luma_[static_cast<std::size_t>(at)] = luma_[static_cast<std::size_t>(at + 1)] = grey;
  }

  std::array<InkFit, kDotCount> fit() const { return fit_sheet(luma(), chroma(), discs, landmark); }
  ImageView luma() const { return {luma_.data(), kSide_px, kSide_px, kSide_px}; }
  ChromaView chroma() const { return {chroma_.data(), chroma_.data() + 1, kSide_px / 2, kSide_px / 2, 2, kSide_px}; }

  const LandmarkGeometry landmark;
  std::array<DiscPicture, kDotCount> discs;

 private:
  CameraModel camera_;
  CameraFromLandmark T_;
  std::vector<std::uint8_t> luma_, chroma_;
};

TEST(SheetFit, FindsEachDotsInkWhateverTheLightsSlope) {
  for (const float slope : {0.0F, 0.6F, -0.6F}) {
    Sheet sheet;
    sheet.draw(0.6F, slope);
    const auto fits = sheet.fit();
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      ASSERT_TRUE(fits[dot].usable) << dot;
      for (Eigen::Index colour = 0; colour < 3; ++colour) EXPECT_NEAR(fits[dot].drop[colour], kDrops[dot], 0.03) << dot;
      EXPECT_NEAR(fits[dot].paper.y(), 0.6F * (1 + slope * (sheet.discs[dot].centre_px.x() / kSide_px - 0.5F)), 0.01);
      EXPECT_LT(std::sqrt(fits[dot].residuals.trace() / fits[dot].freedoms), 0.02) << dot;
    }
  }
}

/// From one dot to the next the errors are as large as the fit says, of samples of one variance.
TEST(SheetFit, SaysHowCertainItIs) {
  double chi2 = 0;
  constexpr int kPictures = 40;
  test::Random random(1);
  for (int i = 0; i < kPictures; ++i) {
    Sheet sheet(0.013 + 0.0007 * i);
    sheet.draw(0.6F);
    const Blocks blocks(sheet.luma(), sheet.chroma());
    for (int y = 0; y < kSide_px / 2; ++y)
      for (int x = 0; x < kSide_px / 2; ++x) {
        const float noise = 0.06F * static_cast<float>(random.normal());  // a tenth of the paper
        sheet.set(x, y, blocks.light_at(x, y).y() + noise);
      }
    const auto fits = sheet.fit();
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
      ASSERT_TRUE(fits[dot].usable) << dot;
      const auto off = static_cast<double>(fits[dot].drop.y() - kDrops[dot]);
      chi2 += off * off / static_cast<double>(0.01F * fits[dot].drop_variance);
    }
  }
  EXPECT_NEAR(chi2 / (kPictures * kRingDotCount), 1, 0.25);
}

TEST(SheetFit, KnowsWhichDotIsNotAsItsModel) {
  Sheet sheet;
  sheet.draw(0.6F);
  // A lamp lights one of P3's blocks.
  const Eigen::Vector2f px = sheet.discs[2].centre_px;
  const auto x = static_cast<int>(px.x() / 2), y = static_cast<int>(px.y() / 2);
  sheet.set(x, y, 0.9F);
  const auto fits = sheet.fit();
  const auto loudness = [&](std::size_t dot) { return fits[dot].residuals.trace() / fits[dot].freedoms; };
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (dot == 2) continue;
    EXPECT_LT(4 * loudness(dot), loudness(2)) << dot;
  }
}

TEST(SheetFit, SaysNothingOfWhatIsNotInThePicture) {
  int cut = 0;
  for (const double x_m : {0.013, 0.31, 1.0, -200.0}) {
    Sheet sheet(x_m);
    sheet.draw(0.6F);
    const auto fits = sheet.fit();
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      const float x_px = sheet.discs[dot].centre_px.x();
      if (x_px > 2 && x_px < kSide_px - 3) {
        EXPECT_TRUE(fits[dot].usable) << x_m << " " << dot;
      }
      if (x_px > kSide_px || x_px < -1) {
        EXPECT_FALSE(fits[dot].usable) << x_m << " " << dot;
      }
      cut += x_px > kSide_px && x_m < 0.5;
    }
  }
  EXPECT_GT(cut, 0) << "or no border crosses a sheet";
}

TEST(SheetFit, SaysNothingInTheDark) {
  Sheet sheet;
  sheet.draw(0.002F);
  for (const InkFit& fit : sheet.fit()) EXPECT_FALSE(fit.usable);
}

}  // namespace
}  // namespace ninedot
