#include "calibrate/camera_file_text.h"

#include <fmt/format.h>

#include "base/one_line.h"
#include "calibrate/camera_file.h"

namespace ninedot {
namespace {

/// In YAML's double quotes.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char letter : one_line(text)) {
    if (letter == '"' || letter == '\\') result += '\\';
    result += letter;
  }
  return result + '"';
}

}  // namespace

std::string format_covariance(const Eigen::MatrixXd& covariance, const std::string& indent) {
  std::string text = fmt::format(
      "{0}covariance:  # of fx, fy, cx, cy and the coefficients in the order above; px and 1\n"
      "{0}  rows: {1}\n{0}  cols: {2}\n{0}  data: [",
      indent, covariance.rows(), covariance.cols());
  for (Eigen::Index row = 0; row < covariance.rows(); ++row)
    for (Eigen::Index column = 0; column < covariance.cols(); ++column)
      text += fmt::format("{}{:.9g}",
                          row + column == 0 ? std::string()
                          : column == 0     ? ",\n" + indent + "         "
                                            : ", ",
                          covariance(row, column));
  return text + "]\n";
}

std::string format_calibrated_camera(const CameraModel& camera, const std::string& camera_name,
                                     const CalibrationNotes& notes) {
  std::string text;
  for (const std::string& line : notes.comments) text += fmt::format("# {}\n", one_line(line));
  text += format_camera(camera, camera_name);
  text += fmt::format(
      "calibration:  # of ninedot; other programs pass over it\n"
      "  date: {}  # UTC\n"
      "  camera_id: {}  # of the camera that this belongs to; empty: unknown\n"
      "  lens: {}\n"
      "  views: {}\n"
      "  rms_px: {:.4g}  # of the outlines\n"
      "  direction_sigma_px: {:.4g}  # expected error of a pixel's direction, median over the picture\n"
      "  direction_sigma_max_px: {:.4g}  # where it is largest\n",
      quoted(notes.date), quoted(notes.camera_id), quoted(notes.lens), notes.views, notes.rms_px,
      notes.direction_sigma_px, notes.direction_sigma_max_px);
  return text + format_covariance(notes.covariance, "  ");
}

}  // namespace ninedot
