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

/// A camera, and a sheet in front of it.
class Sheet {
 public:
  /// \param dot_px  how wide its ring's dots are seen
  explicit Sheet(double x_m = 0.013, double dot_px = 2.4) {
    camera_.width_px = camera_.height_px = kSide_px;
    camera_.cx_px = camera_.cy_px = (kSide_px - 1) / 2.0;
    T_.rotation =
        (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    T_.translation_m = {x_m, 0.021, camera_.fx_px * 2 * landmark.dot_radius_m / dot_px};
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

  /// The same while the picture moves: each point draws a line, and what lies beyond the sheet comes onto it.
  /// \param dark, bright  light of the walls at the beginning and at the end of the lines [1]
  void draw_moving(float paper, const Eigen::Vector2f& line_px, float dark, float bright) {
    constexpr int kMoments = 40;
    const DiscPicture& centre = discs[kCentreDot];
    const auto half_side = static_cast<float>(landmark.paper_radius_m() / landmark.centre_radius_m);
    const auto inside = [&](float at) {  // of one pair of sides, through the blur of a block
      const float depth_px = (half_side - std::abs(at)) * centre.semi_minor_px;
      return 0.5F * (1 + std::erf(depth_px / (kBlockBlur_px * std::sqrt(2.0F))));
    };
    for (int y = 0; y < kSide_px / 2; ++y)
      for (int x = 0; x < kSide_px / 2; ++x) {
        float light = 0;
        for (int moment = 0; moment < kMoments; ++moment) {
          const Eigen::Vector2f px =
              Eigen::Vector2f(2 * static_cast<float>(x) + 0.5F, 2 * static_cast<float>(y) + 0.5F) -
              ((static_cast<float>(moment) + 0.5F) / kMoments - 0.5F) * line_px;
          const Eigen::Vector2f on_sheet = centre.radius_per_px * (px - centre.centre_px);
          const float sheet = inside(on_sheet.x()) * inside(on_sheet.y());
          float share = 1;
          for (std::size_t dot = 0; dot < kDotCount; ++dot)
            share -= kDrops[dot] *
                     discs[dot].cover(discs[dot].inside_px(discs[dot].radius_per_px * (px - discs[dot].centre_px)),
                                      kBlockBlur_px);
          light += sheet * share * paper + (1 - sheet) * ((px - centre.centre_px).dot(line_px) < 0 ? dark : bright);
        }
        set(x, y, light / kMoments);
      }
  }

  std::array<InkFit, kDotCount> fit(const Eigen::Vector2f& line_px = Eigen::Vector2f::Zero()) const {
    return fit_sheet(luma(), chroma(), discs, landmark, line_px);
  }
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

// A camera that turns draws lines of them that are longer than the ring's dots are apart.
TEST(SheetFit, FindsTheInksOfDotsThatDrawLines) {
  for (const Eigen::Vector2f& line_px : {Eigen::Vector2f(5, 0), Eigen::Vector2f(9, 1), Eigen::Vector2f(-2, 8)}) {
    Sheet sheet(0.013, 3.2);
    sheet.draw_moving(0.6F, line_px, 0.1F, 0.4F);
    const auto fits = sheet.fit(line_px), as_if_it_stood = sheet.fit();
    int spoilt = 0;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      ASSERT_TRUE(fits[dot].usable) << dot;
      EXPECT_NEAR(fits[dot].drop.y(), kDrops[dot], 0.08) << dot << ", " << line_px.transpose();
      EXPECT_NEAR(fits[dot].paper.y(), 0.6, 0.02) << dot;
      spoilt += !as_if_it_stood[dot].usable || std::abs(as_if_it_stood[dot].drop.y() - kDrops[dot]) > 0.15F;
    }
    EXPECT_GE(spoilt, 6) << "else lines need no fit of their own";
  }
}

/// From one dot to the next the errors are as large as the fit says, of samples of one variance.
TEST(SheetFit, SaysHowCertainItIs) {
  for (const Eigen::Vector2f& line_px : {Eigen::Vector2f(0, 0), Eigen::Vector2f(8, 1)}) {
    double chi2 = 0;
    constexpr int kPictures = 40;
    test::Random random(1);
    for (int i = 0; i < kPictures; ++i) {
      Sheet sheet(0.013 + 0.0007 * i, line_px.isZero(0) ? 2.4 : 3.2);
      if (line_px.isZero(0))
        sheet.draw(0.6F);
      else
        sheet.draw_moving(0.6F, line_px, 0.1F, 0.4F);
      const Blocks blocks(sheet.luma(), sheet.chroma());
      for (int y = 0; y < kSide_px / 2; ++y)
        for (int x = 0; x < kSide_px / 2; ++x) {
          const float noise = 0.06F * static_cast<float>(random.normal());  // a tenth of the paper
          sheet.set(x, y, blocks.light_at(x, y).y() + noise);
        }
      const auto fits = sheet.fit(line_px);
      for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
        ASSERT_TRUE(fits[dot].usable) << dot;
        const auto off = static_cast<double>(fits[dot].drop.y() - kDrops[dot]);
        chi2 += off * off / static_cast<double>(0.01F * fits[dot].drop_variance);
      }
    }
    EXPECT_NEAR(chi2 / (kPictures * kRingDotCount), 1, 0.25) << line_px.transpose();
  }
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
