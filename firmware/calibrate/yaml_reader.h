#pragma once
/// Strict reading of a calibration file's YAML, with errors that name file and line.
#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "calibrate/calibration_record.h"
#include "geometry/camera_model.h"

namespace ninedot {

/// Every method throws StartupError(kWrongUsage), "NAME:LINE: what is wrong". Threads: one caller.
class YamlReader {
 public:
  /// \param name  of the file; must outlive the reader
  explicit YamlReader(const std::string& name) : name_(name) {}

  [[noreturn]] void refuse(const YAML::Node& where, const std::string& what) const;

  /// \param map  a mapping (contract)
  YAML::Node need(const YAML::Node& map, const char* key) const;

  /// yaml-cpp takes the first of two equal keys; the user may mean the second.
  void refuse_repeated_keys(const YAML::Node& map) const;

  /// Finite. \param what  how errors call it \return  in the unit of what is read [1]
  double read_number(const YAML::Node& node, const std::string& what) const;

  /// A matrix in either form: {rows, cols, data} or the bare list. \return  row by row, in the file's units [1]
  std::vector<double> read_matrix(const YAML::Node& map, const char* key) const;

 private:
  const std::string& name_;
};

/// Of the matrix `covariance` in a mapping: of fx, fy, cx, cy and the coefficients in the file's order [px, 1]; those
/// that a file does not have 0. \param camera  whose intrinsics they are
IntrinsicCovariance read_intrinsic_covariance(const YAML::Node& map, const CameraModel& camera, const YamlReader& yaml);

/// Refuses focal lengths and centres that no lens of the picture's size has. \param where  they stand
void check_intrinsics(const CameraModel& camera, const YAML::Node& where, const YamlReader& yaml);

/// Refuses coefficients with which the middle of the picture, half way to its corners, has no directions.
void check_directions(const CameraModel& camera, const YAML::Node& where, const YamlReader& yaml);

/// The mapping `calibration` of a file. \param camera  of the same file
CalibrationRecord read_calibration_record(const YAML::Node& node, const CameraModel& camera, const YamlReader& yaml);

}  // namespace ninedot
