// The overlay pictures: what is marked where. Positions are predicted by the camera's equations written out here.
#include "drawing/overlay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace ninedot {
namespace {

constexpr int kWidth_px = 640, kHeight_px = 480;

/// Colour classes of the drawing; the frame itself is grey.
bool is_outline(const std::uint8_t* p) { return p[0] > 180 && p[1] < 130 && p[2] > 150; }
bool is_hidden(const std::uint8_t* p) { return p[0] > 180 && p[1] > 90 && p[1] < 180 && p[2] < 90; }
bool is_centroid(const std::uint8_t* p) { return p[0] > 180 && p[1] > 170 && p[2] < 90; }
bool is_red_axis(const std::uint8_t* p) { return p[0] > 200 && p[1] < 90 && p[2] < 90; }
bool is_green_axis(const std::uint8_t* p) { return p[0] < 90 && p[1] > 190 && p[2] < 110; }
bool is_blue_axis(const std::uint8_t* p) { return p[0] < 110 && p[1] < 160 && p[2] > 220; }
using Kind = bool (*)(const std::uint8_t*);

class Overlay : public testing::Test {
 protected:
  Overlay() : pixels_(static_cast<std::size_t>(kStride_bytes * kHeight_px), 128) {
    luma_ = {pixels_.data(), kWidth_px, kHeight_px, kStride_bytes};
    report_.found = report_.valid = report_.calibrated = true;
    report_.reason = Reason::kNone;
    report_.dots_used = 9;
    place_camera_in_front(0.5);
  }

  /// Looks at P9 along the normal: camera x = -X0, y = -Z0, z = -Y0.
  void place_camera_in_front(double distance_m) {
    report_.camera_in_landmark.position_m = {0, distance_m, 0};
    report_.camera_in_landmark.quaternion_wxyz = {0, 0, std::sqrt(0.5), -std::sqrt(0.5)};
    report_.distance_m = distance_m_ = distance_m;
  }

  /// Frame pixel of a point of the sheet for that camera.
  Eigen::Vector2d pixel_px(double x0_m, double z0_m, double k1 = 0) const {
    const double x = -x0_m / distance_m_, y = -z0_m / distance_m_, bend = 1 + k1 * (x * x + y * y);
    return {720 * x * bend + 319.5, 720 * y * bend + 239.5};
  }
  Eigen::Vector2d dot_edge_px(std::size_t dot, double angle_rad, double k1 = 0) const {
    const Eigen::Vector2d m =
        geometry_.centre_m(dot) + geometry_.radius_m(dot) * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    return pixel_px(m.x(), m.y(), k1);
  }

  LandmarkObservation seen_dots() const {
    LandmarkObservation seen;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      DotObservation& d = seen.dots[dot];
      d.seen = true;
      d.centroid_px = pixel_px(geometry_.centre_m(dot).x(), geometry_.centre_m(dot).y());
      d.semi_major_px = d.semi_minor_px = 720 * geometry_.radius_m(dot) / distance_m_;
    }
    seen.seen_count = 9;
    return seen;
  }

  void draw(const LandmarkObservation* seen, int scale = 2, const FailedSearch* failed = nullptr) {
    scale_ = scale;
    draw_overlay(luma_, report_, seen, failed, camera_, geometry_, scale, picture_);
  }

  /// A pixel of the kind within `reach` of where the frame pixel is in the picture.
  bool has(Kind kind, const Eigen::Vector2d& frame_px, int reach = 1) const {
    const int x0 = static_cast<int>(std::lround((frame_px.x() + 0.5) * scale_ - 0.5));
    const int y0 = static_cast<int>(std::lround((frame_px.y() + 0.5) * scale_ - 0.5));
    for (int y = y0 - reach; y <= y0 + reach; ++y)
      for (int x = x0 - reach; x <= x0 + reach; ++x)
        if (x >= 0 && y >= 0 && x < picture_.width_px && y < picture_.height_px && kind(at(x, y))) return true;
    return false;
  }
  /// Within columns [from, to) of the picture.
  int count(Kind kind, int from, int to) const {
    int found = 0;
    for (int y = 0; y < picture_.height_px; ++y)
      for (int x = from; x < to; ++x) found += kind(at(x, y)) ? 1 : 0;
    return found;
  }
  int count_in_frame(Kind kind) const { return count(kind, 0, kWidth_px * scale_); }
  /// The panel above the key to the colours, which shows all of them.
  int count_in_inset(Kind kind) const {
    int found = 0;
    for (int y = 0; y < picture_.height_px * 7 / 8; ++y)
      for (int x = kWidth_px * scale_; x < picture_.width_px; ++x) found += kind(at(x, y)) ? 1 : 0;
    return found;
  }
  const std::uint8_t* at(int x, int y) const {
    return &picture_.pixels[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width_px) +
                                 static_cast<std::size_t>(x))];
  }

  static constexpr int kStride_bytes = kWidth_px + 32;
  std::vector<std::uint8_t> pixels_;
  ImageView luma_;
  Report report_;
  CameraModel camera_;
  LandmarkGeometry geometry_;
  RgbPicture picture_;
  double distance_m_ = 0.5;
  int scale_ = 2;
};

TEST_F(Overlay, DrawsTheOutlineOfEachDiscWhereThePoseProjectsIt) {
  for (const int scale : {1, 2, 3}) {
    draw(nullptr, scale);
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      for (const double angle_rad : {0.3, 1.9, 3.4, 4.0, 5.9})
        EXPECT_TRUE(has(is_outline, dot_edge_px(dot, angle_rad))) << "dot " << dot + 1 << " at scale " << scale;
    EXPECT_FALSE(has(is_outline, pixel_px(-0.045, 0.005), 4)) << "between P9 and P7";
  }
}

TEST_F(Overlay, FollowsTheLensDistortion) {
  constexpr double kK1 = -0.8;  // moves P1 by 0.6 px per 0.01 of it
  camera_.k[0] = kK1;
  draw(nullptr, 4);
  EXPECT_TRUE(has(is_outline, dot_edge_px(0, -std::numbers::pi / 2, kK1), 2));
  EXPECT_FALSE(has(is_outline, dot_edge_px(0, -std::numbers::pi / 2, 0), 2));
}

TEST_F(Overlay, DrawsTheAxesOfTheLandmark) {
  report_.camera_in_landmark.position_m = {-0.1, 0.5, -0.1};  // from the side: Y0 is not a mere point
  draw(nullptr);
  const auto shifted = [](double x_m, double y_m, double z_m) {
    const double depth_m = 0.5 - y_m;
    return Eigen::Vector2d(720 * -(x_m + 0.1) / depth_m + 319.5, 720 * -(z_m + 0.1) / depth_m + 239.5);
  };
  EXPECT_TRUE(has(is_red_axis, shifted(0.04, 0, 0)));
  EXPECT_TRUE(has(is_green_axis, shifted(0, 0.04, 0)));
  EXPECT_TRUE(has(is_blue_axis, shifted(0, 0, 0.04)));
}

TEST_F(Overlay, MarksSeenCentroidsAndDashesHiddenDots) {
  LandmarkObservation seen = seen_dots();
  seen.dots[6].seen = false;  // P7, right
  draw(&seen);
  EXPECT_TRUE(has(is_centroid, seen.dots[0].centroid_px));
  EXPECT_FALSE(has(is_centroid, seen.dots[6].centroid_px));
  int dashes = 0, gaps = 0;
  for (int i = 0; i < 360; ++i) {
    const Eigen::Vector2d edge = dot_edge_px(6, i * std::numbers::pi / 180);
    EXPECT_FALSE(has(is_outline, edge, 2));
    has(is_hidden, edge) ? ++dashes : ++gaps;
  }
  EXPECT_GT(dashes, 90);
  EXPECT_GT(gaps, 60);
}

TEST_F(Overlay, MagnifiesASmallLandmarkBesideTheFrame) {
  place_camera_in_front(4.0);
  const LandmarkObservation seen = seen_dots();
  draw(&seen);
  EXPECT_GT(count_in_inset(is_outline), 500);
  EXPECT_GT(count_in_inset(is_centroid), 50);
  EXPECT_GT(count_in_frame(is_outline), 50) << "brackets";
  EXPECT_EQ(count_in_frame(is_centroid), 0) << "nothing drawn over the small landmark itself";
  place_camera_in_front(0.5);
  draw(nullptr);
  EXPECT_EQ(count_in_inset(is_outline), 0);
}

TEST_F(Overlay, SaysInRedThatThereIsNoLandmark) {
  report_.valid = report_.found = false;
  report_.reason = Reason::kNoLandmark;
  for (const std::uint8_t background : {std::uint8_t{0}, std::uint8_t{128}, std::uint8_t{255}}) {
    std::fill(pixels_.begin(), pixels_.end(), background);
    draw(nullptr);
    EXPECT_EQ(count_in_frame(is_outline), 0) << "the pose of an older frame is not drawn";
    EXPECT_EQ(count_in_frame(is_blue_axis), 0);
    const auto is_words = [](const std::uint8_t* p) {
      return p[0] > 240 && p[1] > 90 && p[1] < 130 && p[2] > 90 && p[2] < 130;
    };
    EXPECT_GT(count_in_frame(is_words), 300) << "background " << int{background};
    const std::uint8_t* verdict = at(picture_.width_px - 4, 4);
    EXPECT_TRUE(verdict[0] > 180 && verdict[1] < 60 && verdict[2] < 60);
  }
}

TEST_F(Overlay, ShowsTheDotsSeenWhenTheyDetermineNoPose) {
  report_.valid = false;
  report_.reason = Reason::kPoseDegenerate;
  LandmarkObservation seen = seen_dots();
  for (const std::size_t dot : {0U, 1U, 2U, 3U}) seen.dots[dot].seen = false;
  draw(&seen);
  EXPECT_TRUE(has(is_outline, dot_edge_px(8, 0.3)));
  EXPECT_TRUE(has(is_centroid, seen.dots[8].centroid_px));
  EXPECT_FALSE(has(is_outline, dot_edge_px(0, 0.3)));
  EXPECT_EQ(count_in_frame(is_green_axis), 0);
}

TEST_F(Overlay, VerdictIsGreenWhenFoundAndAmberWhenAmbiguous) {
  draw(nullptr);
  const std::uint8_t* verdict = at(picture_.width_px - 4, 4);
  EXPECT_TRUE(verdict[1] > 120 && verdict[0] < 60);
  report_.valid = false;
  report_.ambiguous = true;
  draw(nullptr);
  verdict = at(picture_.width_px - 4, 4);
  EXPECT_TRUE(verdict[0] > 180 && verdict[1] > 100 && verdict[2] < 60);
}

TEST_F(Overlay, SizeDependsOnTheFrameAndTheScaleAlone) {
  draw(nullptr);
  const int width = picture_.width_px, height = picture_.height_px;
  EXPECT_EQ(height, 960);
  EXPECT_GT(width, 1280);
  place_camera_in_front(5.0);
  draw(nullptr);
  EXPECT_EQ(picture_.width_px, width);
  report_.valid = report_.found = false;
  draw(nullptr, 0);
  EXPECT_EQ(picture_.width_px, width);
  EXPECT_EQ(picture_.height_px, height);
  EXPECT_EQ(picture_.pixels.size(), static_cast<std::size_t>(3 * width * height));
}

TEST_F(Overlay, EnlargesSmallFramesMore) {
  EXPECT_EQ(overlay_scale(480), 2);
  EXPECT_EQ(overlay_scale(240), 4);
  EXPECT_EQ(overlay_scale(1080), 1);
  EXPECT_EQ(overlay_scale(16), 8);
}

TEST_F(Overlay, ShowsTheFramesOwnPixelsWhateverTheStride) {
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kStride_bytes; ++x)
      pixels_[static_cast<std::size_t>(y * kStride_bytes + x)] = x >= kWidth_px ? 0 : x < kWidth_px / 2 ? 40 : 200;
  report_.valid = report_.found = false;
  draw(nullptr, 1);
  EXPECT_EQ(at(kWidth_px / 2 - 4, 10)[0], 40);
  EXPECT_EQ(at(kWidth_px / 2 + 4, 10)[1], 200);
  EXPECT_EQ(at(kWidth_px - 1, 300)[2], 200);
}

TEST_F(Overlay, DrawsALandmarkPartlyOutsideOfTheFrame) {
  report_.camera_in_landmark.position_m = {0.2, 0.4, 0.1};
  draw(nullptr);
  EXPECT_GT(count_in_frame(is_outline), 500);
  report_.camera_in_landmark.position_m = {0.0, 0.02, 0.0};  // 2 cm before the sheet: the dots are far outside
  EXPECT_NO_FATAL_FAILURE(draw(nullptr));
}

TEST_F(Overlay, DrawsNothingThatIsBehindTheCamera) {
  report_.camera_in_landmark.quaternion_wxyz = {std::sqrt(0.5), -std::sqrt(0.5), 0, 0};  // looks away from the sheet
  const LandmarkObservation seen = seen_dots();
  draw(&seen);
  EXPECT_EQ(count_in_frame(is_outline), 0);
  EXPECT_EQ(count_in_frame(is_red_axis), 0);
}

TEST_F(Overlay, DrawsThePartBeforeTheCameraOfASheetThatReachesBehindIt) {
  // 2 cm before the sheet, looking along it towards P3: camera x = -Y0, y = -Z0, z = X0. P7 lies behind.
  report_.camera_in_landmark.position_m = {-0.02, 0.02, 0.0};
  report_.camera_in_landmark.quaternion_wxyz = {0.5, -0.5, 0.5, -0.5};
  draw(nullptr);
  EXPECT_TRUE(has(is_outline, {720 * 0.2 + 319.5, -720 * 0.127 + 239.5}, 2)) << "top of P3, 10 cm away";
}

TEST_F(Overlay, SurvivesNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  report_.camera_in_landmark.position_m = {nan, 1e300, nan};
  report_.covariance.fill(nan);
  report_.rms_px = report_.ambiguity = report_.distance_m = nan;
  draw(nullptr);
  EXPECT_EQ(count_in_frame(is_outline), 0);
}

TEST_F(Overlay, DrawsIntoFramesOfAFewPixels) {
  luma_ = {pixels_.data(), 16, 16, kStride_bytes};
  draw(nullptr, 0);
  EXPECT_GE(picture_.width_px, 128);
  report_.valid = report_.found = false;
  draw(nullptr, 1);
  EXPECT_GE(picture_.height_px, 16);
}

bool is_spot(const std::uint8_t* p) { return p[0] < 60 && p[1] > 150 && p[2] > 190; }

TEST_F(Overlay, OutlinesTheSpotsAndTheNearestGuessWhereNothingWasFound) {
  report_.valid = report_.found = false;
  report_.reason = Reason::kNoLandmark;
  const std::array<Blob, 1> spots{{{500, 100, 314, 25, 0, 25, 0}}};  // a disc of 10 px
  FailedSearch failed;
  failed.spots = spots;
  failed.refusal = Refusal::kNoCentre;
  failed.dots = seen_dots().dots;
  failed.dots[kCentreDot].seen = false;
  draw(nullptr, 2, &failed);
  for (const double angle_rad : {0.3, 1.9, 3.4, 5.9}) {
    EXPECT_TRUE(has(is_spot, {500 + 10 * std::cos(angle_rad), 100 + 10 * std::sin(angle_rad)}));
    EXPECT_FALSE(has(is_spot, {500 + 14 * std::cos(angle_rad), 100 + 14 * std::sin(angle_rad)}));
    EXPECT_TRUE(has(is_outline, dot_edge_px(2, angle_rad)));
  }
  EXPECT_GT(count_in_frame(is_hidden), 100) << "P9, dashed";
  failed.refusal = Refusal::kNone;
  draw(nullptr, 2, &failed);
  EXPECT_TRUE(has(is_spot, {510, 100}));
  EXPECT_EQ(count_in_frame(is_outline), 0) << "there was no guess";
  failed.refusal = Refusal::kFewOutlines;
  for (const double far : {1e9, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    for (DotObservation& dot : failed.dots) dot.centroid_px = {far, -far};
    draw(nullptr, 2, &failed);
    EXPECT_EQ(count_in_frame(is_hidden), 0);
  }
}

}  // namespace
}  // namespace ninedot
