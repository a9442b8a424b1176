#include "tests/bench/case_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "base/startup_error.h"
#include "calibrate/camera_file.h"
#include "drivers/picture/picture_file.h"
#include "programs/assembly/input_files.h"

namespace ninedot::bench {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& line) { throw StartupError(ExitStatus::kWrongUsage, line); }

/// Fields of a line that ends with a line feed, or with a carriage return before it (RFC 4180).
std::vector<std::string> split(std::string line) {
  std::vector<std::string> fields;
  if (line.ends_with('\r')) line.pop_back();
  std::stringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

/// One row of a CSV file, by the names of the header.
struct Row {
  const std::map<std::string, std::size_t>& columns;
  std::vector<std::string> fields;
  const std::string& where;

  std::string text(const std::string& name) const {
    const auto column = columns.find(name);
    if (column == columns.end()) fail(fmt::format("{}: no column '{}'", where, name));
    return column->second < fields.size() ? fields[column->second] : "";
  }
  double number(const std::string& name) const {
    const std::string value = text(name);
    char* end = nullptr;
    const double parsed = std::strtod(value.c_str(), &end);
    if (value.empty() || *end != '\0') fail(fmt::format("{}: '{}' in column '{}' is no number", where, value, name));
    return parsed;
  }
};

std::vector<std::uint8_t> read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path.string() + ": can't be read");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void read_picture(const fs::path& case_path, PictureDecoder& decoder, PictureSize size, CaseFrame& frame) {
  for (const char* const kind : {"png", "pgm", "ppm", "jpg"}) {
    const fs::path path = case_path / "frames" / fmt::format("{:06}.{}", frame.number, kind);
    if (!fs::exists(path)) continue;
    frame.luma.resize(size.pixel_count());
    frame.colour.resize(2 * size.pixel_count());
    const Result<ChromaView> chroma = decoder.decode_with_chroma(read_file(path), frame.luma, frame.colour);
    if (!chroma) fail(path.string() + ": can't be read, or is not of the calibration's size");
    frame.chroma = *chroma;
    return;
  }
  fail(fmt::format("{}: no picture for frame {} of truth.csv", case_path.string(), frame.number));
}

TruePose true_pose(const Row& row) {
  TruePose pose;
  pose.landmark_id = static_cast<int>(row.number("landmark_id"));
  pose.hidden_fraction = row.number("occluded_fraction");
  pose.T_landmark_camera.translation_m =
      Eigen::Vector3d(row.number("x_mm"), row.number("y_mm"), row.number("z_mm")) / 1000;
  pose.T_landmark_camera.rotation =
      Eigen::Quaterniond(row.number("qw"), row.number("qx"), row.number("qy"), row.number("qz"))
          .normalized()
          .toRotationMatrix();
  return pose;
}

}  // namespace

double TruePose::tilt_rad() const {
  return std::acos(std::clamp(T_landmark_camera.translation_m.y() / distance_m(), -1.0, 1.0));
}

CaseFolder read_case(const std::string& path) {
  const fs::path folder(path);
  CaseFolder result;
  result.name = fs::canonical(folder).filename().string();
  result.camera = read_camera_file((folder / "camera.yaml").string());
  const PictureSize size{result.camera.width_px, result.camera.height_px};
  PictureDecoder decoder(size);

  const std::string where = (folder / "truth.csv").string();
  std::ifstream file(where);
  std::string line;
  if (!std::getline(file, line)) fail(where + ": can't be read, or is empty");
  std::map<std::string, std::size_t> columns;
  for (const std::string& name : split(line)) columns.emplace(name, columns.size());
  while (std::getline(file, line)) {
    if (line.empty()) continue;
    const Row row{columns, split(line), where};
    const int number = static_cast<int>(row.number("frame"));
    if (result.frames.empty() || result.frames.back().number != number) {
      CaseFrame& frame = result.frames.emplace_back();
      frame.number = number;
      frame.timestamp_ns = static_cast<std::int64_t>(row.number("timestamp_ns"));
      read_picture(folder, decoder, size, frame);
    }
    if (row.number("visible") != 0) result.frames.back().landmarks.push_back(true_pose(row));
  }
  if (result.frames.empty()) fail(where + ": no frames");
  return result;
}

std::vector<std::string> find_cases(const std::string& path) {
  if (fs::exists(fs::path(path) / "truth.csv")) return {path};
  std::vector<std::string> cases;
  if (fs::is_directory(path)) {
    for (const auto& entry : fs::directory_iterator(path)) {
      if (fs::exists(entry.path() / "truth.csv")) cases.push_back(entry.path().string());
    }
  }
  if (cases.empty()) fail(path + ": no recording with a truth.csv in it");
  std::sort(cases.begin(), cases.end());
  return cases;
}

}  // namespace ninedot::bench
