#pragma once
/// Drawing for overlay.cpp: a picture with a map from frame pixels into it, lines and text that are legible on
/// anything.
#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>

#include "geometry/camera_model.h"
#include "geometry/transform.h"

namespace ninedot::overlay {

using Colour = cv::Scalar;  ///< red, green, blue

/// Chosen to differ in brightness from black ink and from white paper alike, and from the three axes.
inline const Colour kOutline{255, 60, 220}, kHidden{255, 140, 40}, kRing{0, 190, 230}, kCentroid{255, 235, 0};
inline const Colour kAxisX{255, 50, 50}, kAxisY{40, 220, 70}, kAxisZ{70, 130, 255};
inline const Colour kText{240, 240, 240}, kFaint{165, 170, 180}, kBacking{24, 27, 33}, kBlack{0, 0, 0};
inline const Colour kGood{30, 150, 70}, kDoubtful{205, 130, 0}, kBad{200, 45, 45};

/// Points of the landmark's frame into frame pixels, through the whole camera model.
class Projector {
 public:
  Projector(const CameraModel& camera, const Transform<frame::Landmark, frame::Camera>& T_landmark_camera)
      : camera_(camera), T_camera_landmark_(T_landmark_camera.inverse()) {}

  /// \return  frame pixels [px]; nothing for a point behind the camera, beyond the field in which the lens model is
  /// one-to-one, or so far outside of the picture that drawing it means nothing.
  std::optional<Eigen::Vector2d> operator()(const Eigen::Vector3d& p_landmark_m) const;

 private:
  CameraModel camera_;
  CameraFromLandmark T_camera_landmark_;
};

/// Where a text stands in relation to its anchor point.
enum class Align { kLeft, kCentre, kRight };

/// A part of an RGB picture that shows the frame, or a cut-out of it, enlarged.
struct Canvas {
  cv::Mat picture;                  ///< CV_8UC3 in the order red, green, blue; shares its memory
  double scale = 1;                 ///< picture pixels per frame pixel
  Eigen::Vector2d origin_px{0, 0};  ///< frame pixel whose upper left corner is that of the picture
  double line_px = 1;               ///< width of a thin line in the picture; text grows with it

  /// Picture pixel of a frame pixel; pixel centres are integers in both.
  Eigen::Vector2d at(const Eigen::Vector2d& pixel_px) const {
    return (pixel_px - origin_px + Eigen::Vector2d(0.5, 0.5)) * scale - Eigen::Vector2d(0.5, 0.5);
  }
};

/// One line from picture pixel `a` to `b`, anti-aliased and with sub-pixel ends. \param width_px  at least 1
void draw_line(cv::Mat& picture, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Colour& colour,
               double width_px);

/// A chain of points of the landmark's frame; where one cannot be projected the chain is broken.
/// \param dash_px  length of a dash and of a gap in picture pixels; 0 = unbroken
void draw_chain(Canvas& canvas, const Projector& project, std::span<const Eigen::Vector3d> chain_m,
                const Colour& colour, double width_px, double dash_px = 0);

/// \param size  height of a capital letter in picture pixels
/// \param at    left, middle or right end of the base line, in picture pixels
/// \param halo  with a dark border around each letter, for text that stands in the frame itself
void draw_text(cv::Mat& picture, const std::string& text, const Eigen::Vector2d& at, double size, const Colour& colour,
               Align align = Align::kLeft, bool halo = false);

}  // namespace ninedot::overlay
