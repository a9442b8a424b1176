#include "calibrate/zoom_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "calibrate/camera_file_text.h"

namespace ninedot {
namespace {

constexpr int kMaxPosition = 0xFFFF;  // what VISCA can say

std::size_t coefficient_count(DistortionModel model) {
  return model == DistortionModel::kRationalPolynomial ? 8 : model == DistortionModel::kEquidistant ? 4 : 5;
}

ZoomLens read_lens(const YAML::Node& node, const CameraModel& like, const YamlReader& yaml) {
  if (!node.IsMap()) yaml.refuse(node, "a position of zoom is no mapping of position, parameters and covariance");
  yaml.refuse_repeated_keys(node);
  ZoomLens lens;
  lens.camera = like;
  const YAML::Node position = yaml.need(node, "position");
  const double zoom = yaml.read_number(position, "position");
  if (zoom != std::floor(zoom) || zoom < 0 || zoom > kMaxPosition)
    yaml.refuse(position,
                fmt::format("position is {}, not a whole number from 0 to {}", position.Scalar(), kMaxPosition));
  lens.zoom = static_cast<int>(zoom);
  const std::vector<double> numbers = yaml.read_matrix(node, "parameters");
  const std::size_t expected = 4 + coefficient_count(like.model);
  if (numbers.size() != expected)
    yaml.refuse(node["parameters"],
                fmt::format("parameters has {} numbers; fx, fy, cx, cy and the coefficients of the file's model are {}",
                            numbers.size(), expected));
  lens.camera.fx_px = numbers[0], lens.camera.fy_px = numbers[1];
  lens.camera.cx_px = numbers[2], lens.camera.cy_px = numbers[3];
  lens.camera.k = {};
  for (std::size_t i = 4; i < expected; ++i) lens.camera.k[i - 4] = numbers[i];
  check_intrinsics(lens.camera, node["parameters"], yaml);
  check_directions(lens.camera, node["parameters"], yaml);
  yaml.need(node, "covariance");
  lens.covariance = read_intrinsic_covariance(node, lens.camera, yaml);
  return lens;
}

}  // namespace

ZoomTable read_zoom(const YAML::Node& node, const CameraModel& camera, const YamlReader& yaml) {
  if (!node.IsMap()) yaml.refuse(node, "zoom is no mapping: write `positions:` below it, or remove it");
  yaml.refuse_repeated_keys(node);
  const YAML::Node positions = yaml.need(node, "positions");
  if (!positions.IsSequence()) yaml.refuse(positions, "positions is no list");
  std::vector<ZoomLens> lenses;
  for (const YAML::Node& position : positions) {
    lenses.push_back(read_lens(position, camera, yaml));
    if (lenses.size() > 1 && lenses.back().zoom < lenses[lenses.size() - 2].zoom)
      yaml.refuse(position, fmt::format("position {} comes after {}: write them by rising position", lenses.back().zoom,
                                        lenses[lenses.size() - 2].zoom));
  }
  if (const auto lack = what_zooms_lack(lenses)) yaml.refuse(positions, *lack);
  ZoomTable table(std::move(lenses));
  if (const auto lack = what_gaps_lack(table)) yaml.refuse(positions, *lack);
  return table;
}

std::string format_zoom(const ZoomTable& zoom) {
  std::string text =
      "zoom:  # of ninedot: the lens at each position of its zoom; other programs pass over it\n"
      "  positions:  # parameters: fx, fy, cx, cy and the coefficients in the order above; px and 1\n";
  for (const ZoomLens& lens : zoom.lenses()) {
    const auto coefficients = coefficient_count(lens.camera.model);
    text += fmt::format(
        "    - position: {}\n      parameters: [{}, {}, {}, {}, {}]\n", lens.zoom, lens.camera.fx_px, lens.camera.fy_px,
        lens.camera.cx_px, lens.camera.cy_px,
        fmt::join(lens.camera.k.begin(), lens.camera.k.begin() + static_cast<std::ptrdiff_t>(coefficients), ", "));
    const auto rows = static_cast<Eigen::Index>(4 + coefficients);
    text += format_covariance(lens.covariance.topLeftCorner(rows, rows), "      ");
  }
  return text;
}

}  // namespace ninedot
