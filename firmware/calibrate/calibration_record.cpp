// As strict as the camera's own numbers: a covariance that is wrong makes poses confident that are not.
#include "calibrate/calibration_record.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <string_view>
#include <vector>

#include "base/one_line.h"
#include "calibrate/yaml_reader.h"

namespace ninedot {
namespace {

using YAML::Node;

/// Of the correlations' eigenvalues and symmetry: what a file with seven digits leaves.
constexpr double kRounding = 1e-5;
/// Nobody's coefficient is less certain; whoever knows a focal length or a middle no better than to the picture's width
/// does not know it.
constexpr double kMaxCoefficientSigma = 1e3;
constexpr int kMaxViews = 1'000'000;

/// "2026-11-22", a day that there is.
bool is_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  const auto number = [&](std::size_t at, std::size_t count) {
    int value = -1;
    const char* const end = text.data() + at + count;
    return std::from_chars(text.data() + at, end, value).ptr == end ? value : -1;
  };
  const int year = number(0, 4), month = number(5, 2), day = number(8, 2);
  if (year < 1970 || month < 1 || day < 1) return false;
  return std::chrono::year_month_day(std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                     std::chrono::day(static_cast<unsigned>(day)))
      .ok();
}

/// How many coefficients a model's file has; of plumb_bob those that are there.
std::size_t coefficients_of(const CameraModel& camera, std::size_t rows) {
  if (camera.model == DistortionModel::kRationalPolynomial) return 8;
  if (camera.model == DistortionModel::kEquidistant) return 4;
  return rows == 4 || rows == 8 ? rows - 4 : 5;  // OpenCV leaves k3 out, or all of them
}

class CovarianceReader {
 public:
  CovarianceReader(const Node& map, const CameraModel& camera, const YamlReader& yaml)
      : map_(map), camera_(camera), yaml_(yaml) {}

  IntrinsicCovariance read() const {
    const Node node = map_["covariance"];
    const std::vector<double> data = yaml_.read_matrix(map_, "covariance");
    const auto rows = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(data.size()))));
    const std::size_t expected = 4 + coefficients_of(camera_, rows);
    if (data.size() != expected * expected)
      yaml_.refuse(node,
                   fmt::format("covariance has {} numbers; of fx, fy, cx, cy and {} coefficients there are {} x {}",
                               data.size(), expected - 4, expected, expected));
    IntrinsicCovariance covariance = IntrinsicCovariance::Zero();
    for (std::size_t i = 0; i < data.size(); ++i)
      covariance(static_cast<Eigen::Index>(i / expected), static_cast<Eigen::Index>(i % expected)) = data[i];
    check_sigmas(covariance, node);
    check_correlations(covariance, node);
    return (covariance + covariance.transpose()) / 2;
  }

 private:
  void check_sigmas(const IntrinsicCovariance& covariance, const Node& node) const {
    if (covariance.isZero(0))
      yaml_.refuse(node, "covariance is 0, and nothing is known so well: remove it, or calibrate");
    for (Eigen::Index i = 0; i < kIntrinsics; ++i) {
      const double largest = i < 4 ? camera_.width_px : kMaxCoefficientSigma;
      if (covariance(i, i) < 0 || covariance(i, i) > largest * largest)
        yaml_.refuse(node, fmt::format("covariance, row {0}, column {0} is {1}; a variance is from 0 to {2}", i + 1,
                                       covariance(i, i), largest * largest));
    }
  }

  void check_correlations(const IntrinsicCovariance& covariance, const Node& node) const {
    IntrinsicCovariance correlation = IntrinsicCovariance::Identity();
    for (Eigen::Index row = 0; row < kIntrinsics; ++row)
      for (Eigen::Index column = 0; column < kIntrinsics; ++column) {
        if (row == column) continue;
        const double sigmas = std::sqrt(covariance(row, row)) * std::sqrt(covariance(column, column));
        if (sigmas == 0 && covariance(row, column) != 0)
          yaml_.refuse(node, fmt::format("covariance, row {}, column {} is {} where a variance is 0", row + 1,
                                         column + 1, covariance(row, column)));
        if (sigmas > 0) correlation(row, column) = covariance(row, column) / sigmas;
      }
    if (!correlation.allFinite() || !((correlation - correlation.transpose()).cwiseAbs().maxCoeff() <= kRounding))
      yaml_.refuse(node, "covariance is not symmetric");
    const Eigen::SelfAdjointEigenSolver<IntrinsicCovariance> solver(correlation, Eigen::EigenvaluesOnly);
    if (!(solver.eigenvalues().minCoeff() >= -kRounding))
      yaml_.refuse(node, "covariance is none: an eigenvalue is negative");
  }

  const Node& map_;
  const CameraModel& camera_;
  const YamlReader& yaml_;
};

class RecordReader {
 public:
  RecordReader(const Node& node, const CameraModel& camera, const YamlReader& yaml)
      : node_(node), camera_(camera), yaml_(yaml) {}

  CalibrationRecord read() const {
    if (!node_.IsMap()) yaml_.refuse(node_, "calibration is no mapping: write its keys below it, or remove it");
    yaml_.refuse_repeated_keys(node_);
    CalibrationRecord record;
    record.date = text("date");
    if (!record.date.empty() && !is_day(record.date))
      yaml_.refuse(node_["date"], fmt::format("date is '{}', not a day such as \"2026-11-22\"", one_line(record.date)));
    record.camera_id = text("camera_id");
    record.lens = text("lens");
    if (const auto views = number("views")) {
      if (*views != std::floor(*views) || *views > kMaxViews)
        yaml_.refuse(node_["views"], fmt::format("views is {}, not a whole number up to {}", *views, kMaxViews));
      record.views = static_cast<int>(*views);
    }
    record.rms_px = number("rms_px");
    record.direction_sigma_px = number("direction_sigma_px");
    record.direction_sigma_max_px = number("direction_sigma_max_px");
    if (node_["covariance"]) record.covariance = read_intrinsic_covariance(node_, camera_, yaml_);
    return record;
  }

 private:
  std::string text(const char* key) const {
    const Node node = node_[key];
    if (!node || node.IsNull()) return {};
    if (!node.IsScalar()) yaml_.refuse(node, fmt::format("{} is not a text", key));
    const std::string& value = node.Scalar();
    if (one_line(value) != value) yaml_.refuse(node, fmt::format("{} is not one line of text", key));
    return value;
  }

  std::optional<double> number(const char* key) const {
    const Node node = node_[key];
    if (!node || node.IsNull()) return std::nullopt;
    const double value = yaml_.read_number(node, key);
    if (value < 0) yaml_.refuse(node, fmt::format("{} is {}; it can't be below 0", key, value));
    return value;
  }

  const Node& node_;
  const CameraModel& camera_;
  const YamlReader& yaml_;
};

}  // namespace

IntrinsicCovariance read_intrinsic_covariance(const Node& map, const CameraModel& camera, const YamlReader& yaml) {
  return CovarianceReader(map, camera, yaml).read();
}

CalibrationRecord read_calibration_record(const Node& node, const CameraModel& camera, const YamlReader& yaml) {
  return RecordReader(node, camera, yaml).read();
}

}  // namespace ninedot
