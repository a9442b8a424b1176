// Each pixel of the sheet is the Gaussian-weighted mean of 9 x 9 rays through the frame's camera model, over +-1.5 px.
#include "tests/bench/tag_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>

#include "base/contract.h"
#include "tests/bench/apriltag_headers.h"
#include "tests/bench/picture_quality.h"

namespace ninedot::bench {
namespace {

using Pose = Transform<frame::Landmark, frame::Camera>;

/// One tag as a grid of cells, its white border included.
class TagCells {
 public:
  TagCells() {
    apriltag_family_t* const family = tag36h11_create();
    image_u8_t* const image = apriltag_to_image(family, 0);
    side_ = image->width;
    for (int y = 0; y < side_; ++y) {
      for (int x = 0; x < side_; ++x) white_.push_back(image->buf[y * image->stride + x] > 127);
    }
    // image_u8_destroy frees these two, and Debian's library does not export it.
    std::free(image->buf);
    std::free(image);
    tag36h11_destroy(family);
    EXPECTS(side_ == 10);
  }
  /// 0 ink .. 1 paper. \param point_m  (X0, Z0), inside the sheet (contract)
  double paper(const Eigen::Vector2d& point_m) const {
    const auto cell = [&](double from_left_m) {
      return std::clamp(static_cast<int>(from_left_m / kTagSheetSide_m * side_), 0, side_ - 1);
    };
    // X0 points to the viewer's left and Z0 up; the grid runs right and down.
    const int x = cell(kTagSheetSide_m / 2 - point_m.x()), y = cell(kTagSheetSide_m / 2 - point_m.y());
    return white_[static_cast<std::size_t>(y * side_ + x)] ? 1 : 0;
  }

 private:
  int side_ = 0;
  std::vector<bool> white_;
};

struct Levels {
  double paper_lsb = 200, ink_lsb = 60;
};

/// Paper beside P9 and ink in its middle.
Levels levels_at(const CaseFolder& recording, const CaseFrame& frame, const Pose& pose) {
  const ImageView luma = recording.view(frame);
  const LandmarkGeometry landmark;
  const auto grey = [&](const Eigen::Vector2d& point_m, double otherwise) {
    const auto pixel = pixel_of_sheet(recording.camera, pose, point_m);
    if (!pixel) return otherwise;
    const int x = static_cast<int>(std::lround(pixel->x())), y = static_cast<int>(std::lround(pixel->y()));
    return luma.contains(x, y) ? static_cast<double>(luma.at(x, y)) : otherwise;
  };
  Levels levels;
  const double beside_m = (landmark.centre_radius_m + landmark.ring_radius_m - landmark.dot_radius_m) / 2;
  levels.paper_lsb = std::max(grey({beside_m, 0}, levels.paper_lsb), grey({-beside_m, 0}, levels.paper_lsb));
  levels.ink_lsb = grey({0, 0}, levels.ink_lsb);
  return levels;
}

/// Mean of the tag over a pixel's point spread; none where part of it misses the sheet.
std::optional<double> paper_under_pixel(const TagCells& tag, const CaseFolder& recording, const Pose& pose, int x,
                                        int y, double blur_px) {
  double sum = 0, weights = 0;
  for (int j = -4; j <= 4; ++j) {
    for (int i = -4; i <= 4; ++i) {
      const double dx = 0.375 * i, dy = 0.375 * j;
      const auto point_m = sheet_of_pixel(recording.camera, pose, {x + dx, y + dy});
      if (!point_m || point_m->cwiseAbs().maxCoeff() > kTagSheetSide_m / 2) return std::nullopt;
      const double weight = std::exp(-(dx * dx + dy * dy) / (2 * blur_px * blur_px));
      sum += weight * tag.paper(*point_m);
      weights += weight;
    }
  }
  return sum / weights;
}

}  // namespace

std::vector<std::uint8_t> paste_tag(const CaseFolder& recording, const CaseFrame& frame) {
  EXPECTS(frame.landmarks.size() == 1);
  const Pose& pose = frame.landmarks.front().T_landmark_camera;
  const TagCells tag;
  const auto quality = measure_quality(recording.view(frame), recording.camera, LandmarkGeometry{}, pose)
                           .value_or(PictureQuality{100, 2, 0.6});
  const Levels levels = levels_at(recording, frame, pose);
  std::mt19937 random(static_cast<std::mt19937::result_type>(frame.number));
  std::normal_distribution<double> noise_lsb(0, quality.noise_lsb);

  std::vector<std::uint8_t> picture = frame.luma;
  for (int y = 0; y < recording.camera.height_px; ++y) {
    for (int x = 0; x < recording.camera.width_px; ++x) {
      const auto middle_m = sheet_of_pixel(recording.camera, pose, {x, y});
      if (!middle_m || middle_m->cwiseAbs().maxCoeff() > kTagSheetSide_m / 2) continue;
      const auto paper = paper_under_pixel(tag, recording, pose, x, y, quality.blur_px);
      if (!paper) continue;  // the sheet's rim stays as it was
      const double grey = levels.ink_lsb + (levels.paper_lsb - levels.ink_lsb) * *paper + noise_lsb(random);
      picture[static_cast<std::size_t>(y * recording.camera.width_px + x)] =
          static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
    }
  }
  return picture;
}

Eigen::Vector3d camera_position_m(const Eigen::Matrix3d& R_camera_tag, const Eigen::Vector3d& t_camera_tag_m) {
  const Eigen::Vector3d in_tag_m = -(R_camera_tag.transpose() * t_camera_tag_m);
  return {-in_tag_m.x(), -in_tag_m.z(), -in_tag_m.y()};
}

}  // namespace ninedot::bench
