#pragma once
/// A recording with ground truth, whole in memory: what the benchmarks measure on.
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/camera_model.h"
#include "geometry/transform.h"
#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot::bench {

/// Where the camera really was: one row of truth.csv that shows a landmark.
struct TruePose {
  int landmark_id = 0;
  Transform<frame::Landmark, frame::Camera> T_landmark_camera;
  double hidden_fraction = 0;  ///< of the sheet, 0..1

  double distance_m() const { return T_landmark_camera.translation_m.norm(); }
  /// Between the line of sight to P9 and the sheet's normal.
  double tilt_rad() const;
};

struct CaseFrame {
  int number = 0;
  std::int64_t timestamp_ns = 0;
  std::vector<std::uint8_t> luma;    ///< rows without gaps
  std::vector<std::uint8_t> colour;  ///< where `chroma` looks
  ChromaView chroma;                 ///< empty: the picture is grey. Valid while the frame lives
  std::vector<TruePose> landmarks;   ///< none: the picture shows no landmark
};

struct CaseFolder {
  std::string name;  ///< last part of the path: tells which limits apply
  CameraModel camera;
  std::vector<CaseFrame> frames;  ///< in the order of truth.csv

  /// Valid while the case lives.
  ImageView view(const CaseFrame& frame) const {
    return {frame.luma.data(), camera.width_px, camera.height_px, camera.width_px};
  }
};

/// Reads camera.yaml, truth.csv and the pictures that it names. Throws StartupError with what is missing.
CaseFolder read_case(const std::string& path);

/// The folders under `path` that hold a truth.csv (or `path` itself if it does), sorted by name.
/// Throws StartupError when there is none.
std::vector<std::string> find_cases(const std::string& path);

}  // namespace ninedot::bench
