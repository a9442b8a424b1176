// Strict about what it reads: a calibration that is wrong in one number gives poses that are wrong and look right.
#include "calibrate/camera_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <optional>
#include <vector>

#include "base/one_line.h"
#include "base/startup_error.h"
#include "calibrate/yaml_reader.h"
#include "calibrate/zoom_file.h"

namespace ninedot {
namespace {

constexpr int kMaxSide_px = 8192;  // as [camera] width_px and height_px of the configuration
/// Focal lengths beyond these multiples of the width are no lenses, but millimetres or typing errors.
constexpr double kMinFocalPerWidth = 0.1;
constexpr double kMaxFocalPerWidth = 100;

class CameraParser {
 public:
  CameraParser(const YAML::Node& root, const YamlReader& yaml) : root_(root), yaml_(yaml) {}

  CameraModel parse() const {
    if (!root_.IsMap()) yaml_.refuse(root_, "not a calibration: expected 'key: value' lines");
    yaml_.refuse_repeated_keys(root_);
    CameraModel camera;
    camera.width_px = read_side_px("image_width");
    camera.height_px = read_side_px("image_height");
    read_camera_matrix(camera);
    read_distortion(camera);
    return camera;
  }

 private:
  int read_side_px(const char* key) const {
    const YAML::Node node = yaml_.need(root_, key);
    const double side_px = yaml_.read_number(node, key);
    if (side_px != std::floor(side_px) || side_px < 1 || side_px > kMaxSide_px)
      yaml_.refuse(node,
                   fmt::format("{} is {}, not a whole number of pixels from 1 to {}", key, node.Scalar(), kMaxSide_px));
    return static_cast<int>(side_px);
  }

  void read_camera_matrix(CameraModel& camera) const {
    const YAML::Node node = yaml_.need(root_, "camera_matrix");
    const std::vector<double> K = yaml_.read_matrix(root_, "camera_matrix");
    if (K.size() != 9) yaml_.refuse(node, fmt::format("camera_matrix has {} numbers instead of 9", K.size()));
    if (K[1] != 0) yaml_.refuse(node, fmt::format("camera_matrix has a skew of {} px; write 0", K[1]));
    if (K[3] != 0 || K[6] != 0 || K[7] != 0 || K[8] != 1)
      yaml_.refuse(node, "camera_matrix is not [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
    camera.fx_px = K[0], camera.cx_px = K[2], camera.fy_px = K[4], camera.cy_px = K[5];
    check_intrinsics(camera, node, yaml_);
  }

  std::optional<DistortionModel> read_model() const {
    const YAML::Node fisheye = root_["fisheye_model"];
    const bool is_fisheye = fisheye && yaml_.read_number(fisheye, "fisheye_model") != 0;
    const YAML::Node node = root_["distortion_model"];
    if (!node) return is_fisheye ? std::optional(DistortionModel::kEquidistant) : std::nullopt;
    const std::string model = node.IsScalar() ? node.Scalar() : std::string();
    if (model == "plumb_bob") return DistortionModel::kPlumbBob;
    if (model == "rational_polynomial") return DistortionModel::kRationalPolynomial;
    if (model == "equidistant" || model == "fisheye") return DistortionModel::kEquidistant;
    yaml_.refuse(
        node,
        fmt::format("unknown distortion_model '{}'; there are plumb_bob, rational_polynomial, equidistant", model));
  }

  void read_distortion(CameraModel& camera) const {
    const std::optional<DistortionModel> model = read_model();
    if (!model && !root_["distortion_coefficients"])
      yaml_.refuse(root_, "'distortion_coefficients' is missing; all 0 for none");
    const YAML::Node node = yaml_.need(root_, "distortion_coefficients");
    std::vector<double> coefficients = yaml_.read_matrix(root_, "distortion_coefficients");
    // OpenCV writes 12 or 14 for its thin-prism and tilt models; those beyond the eighth may be 0 only.
    while (coefficients.size() > 8 && coefficients.back() == 0) coefficients.pop_back();
    const std::size_t count = coefficients.size();
    const bool counts_as_rational = count > 5 && count <= 8;
    camera.model =
        model.value_or(counts_as_rational ? DistortionModel::kRationalPolynomial : DistortionModel::kPlumbBob);
    const auto expect = [&](bool fits, const char* name, const char* counts) {
      if (!fits) yaml_.refuse(node, fmt::format("{} takes {} coefficients; there are {}", name, counts, count));
    };
    switch (camera.model) {
      case DistortionModel::kPlumbBob:
        expect(count == 0 || count == 4 || count == 5, "plumb_bob", "0, 4 or 5");
        break;
      case DistortionModel::kRationalPolynomial:
        expect(count == 8, "rational_polynomial", "8");
        break;
      case DistortionModel::kEquidistant:
        expect(count == 4, "equidistant", "4");
        break;
    }
    for (std::size_t i = 0; i < count; ++i) camera.k[i] = coefficients[i];
    check_directions(camera, node, yaml_);
  }

  const YAML::Node& root_;
  const YamlReader& yaml_;
};

/// OpenCV starts its files with %YAML:1.0, which YAML itself does not know: the line is blanked, so that line numbers
/// stay.
std::string without_opencv_directive(std::string_view text) {
  std::string copy(text);
  if (copy.starts_with("%YAML:"))
    for (std::size_t i = 0; i < copy.size() && copy[i] != '\n'; ++i) copy[i] = ' ';
  return copy;
}

}  // namespace

void check_intrinsics(const CameraModel& camera, const YAML::Node& where, const YamlReader& yaml) {
  for (const auto& [focal_px, name] : {std::pair{camera.fx_px, "fx"}, std::pair{camera.fy_px, "fy"}}) {
    if (focal_px <= 0) yaml.refuse(where, fmt::format("{} is {} px; a focal length is positive", name, focal_px));
    if (focal_px < kMinFocalPerWidth * camera.width_px || focal_px > kMaxFocalPerWidth * camera.width_px)
      yaml.refuse(where, fmt::format("{} is {} px, implausible for a picture {} px wide; it is in pixels, not mm", name,
                                     focal_px, camera.width_px));
  }
  if (camera.cx_px < 0 || camera.cx_px > camera.width_px || camera.cy_px < 0 || camera.cy_px > camera.height_px)
    yaml.refuse(where, fmt::format("the principal point ({}, {}) is outside the picture of {} x {} px", camera.cx_px,
                                   camera.cy_px, camera.width_px, camera.height_px));
}

void check_directions(const CameraModel& camera, const YAML::Node& where, const YamlReader& yaml) {
  for (const double x : {0.25, 0.75})
    for (const double y : {0.25, 0.75})
      if (!camera.normalised_from_pixel({x * camera.width_px, y * camera.height_px}))
        yaml.refuse(where,
                    "with these coefficients pixels half way to the corners have no direction: no lens bends so");
}

CameraCalibration parse_calibration(std::string_view text, const std::string& name) {
  YAML::Node root;
  try {
    root = YAML::Load(without_opencv_directive(text));
    const YamlReader yaml(name);
    CameraCalibration calibration{CameraParser(root, yaml).parse(), {}, {}};
    if (const YAML::Node record = root["calibration"]; record)
      calibration.record = read_calibration_record(record, calibration.camera, yaml);
    if (const YAML::Node zoom = root["zoom"]; zoom) calibration.zoom = read_zoom(zoom, calibration.camera, yaml);
    return calibration;
  } catch (const YAML::Exception& error) {
    const int line = error.mark.is_null() ? 1 : error.mark.line + 1;
    throw StartupError(ExitStatus::kWrongUsage, one_line(fmt::format("{}:{}: not YAML: {}", name, line, error.msg)));
  }
}

CameraModel parse_camera(std::string_view text, const std::string& name) {
  return parse_calibration(text, name).camera;
}

std::string format_camera(const CameraModel& camera, const std::string& camera_name) {
  const char* model = "plumb_bob";
  std::size_t count = 5;
  if (camera.model == DistortionModel::kRationalPolynomial) model = "rational_polynomial", count = 8;
  if (camera.model == DistortionModel::kEquidistant) model = "equidistant", count = 4;
  return fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: {}\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{fx}, 0, {cx}, 0, {fy}, {cy}, 0, 0, 1]\n"
      "distortion_model: {}\n"
      "distortion_coefficients:\n  rows: 1\n  cols: {}\n  data: [{}]\n"
      "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
      "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [{fx}, 0, {cx}, 0, 0, {fy}, {cy}, 0, 0, 0, 1, 0]\n",
      camera.width_px, camera.height_px, camera_name, model, count,
      fmt::join(camera.k.begin(), camera.k.begin() + static_cast<std::ptrdiff_t>(count), ", "),
      fmt::arg("fx", camera.fx_px), fmt::arg("fy", camera.fy_px), fmt::arg("cx", camera.cx_px),
      fmt::arg("cy", camera.cy_px));
}

}  // namespace ninedot
