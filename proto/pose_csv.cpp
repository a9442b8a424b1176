#include "proto/pose_csv.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "base/contract.h"
#include "base/units.h"

namespace ninedot {
namespace {

constexpr double kMmPerM = 1000;
/// mm and deg to 1e-6, quaternions to 1e-9 (2e-9 rad): a thousandth of the best 1-sigma of one frame, and short to
/// read.
constexpr int kLengthDigits = 6;
constexpr int kQuaternionDigits = 9;

constexpr std::string_view kHeader =
    "frame,timestamp_ns,landmark_id,x_mm,y_mm,z_mm,qw,qx,qy,qz,psi_deg,phi_deg,theta_deg,distance_mm,"
    "sigma_x_mm,sigma_y_mm,sigma_z_mm,sigma_rot_deg,ambiguity,rms_px,dots,occlusion_level,solver,process_us\n";
constexpr std::string_view kHeaderWithoutTime =
    "frame,timestamp_ns,landmark_id,x_mm,y_mm,z_mm,qw,qx,qy,qz,psi_deg,phi_deg,theta_deg,distance_mm,"
    "sigma_x_mm,sigma_y_mm,sigma_z_mm,sigma_rot_deg,ambiguity,rms_px,dots,occlusion_level,solver\n";

/// Fixed-point text; what rounds to zero has no sign.
void append(std::string& text, double value, int digits) {
  const std::size_t start = text.size();
  fmt::format_to(std::back_inserter(text), "{:.{}f}", value, digits);
  if (text[start] == '-' && text.find_first_of("123456789n", start) == std::string::npos) text.erase(start, 1);
}

const char* solver_name(Solver solver) {
  switch (solver) {
    case Solver::kFull:
      return "full";
    case Solver::kEllipse:
      return "ellipse";
  }
  return "?";
}

double variance(const Report& report, std::size_t axis) { return report.covariance[axis * 7]; }

}  // namespace

std::string_view pose_csv_header(PoseCsvColumns columns) noexcept {
  return columns == PoseCsvColumns::kAll ? kHeader : kHeaderWithoutTime;
}

std::string format_pose_csv_row(const Report& report, PoseCsvColumns columns) {
  EXPECTS(report.valid);
  std::string row = fmt::format("{},{},{}", report.frame_number, to_ns(report.exposed_at), report.landmark_id);
  const auto add = [&row](double value, int digits) {
    row += ',';
    append(row, value, digits);
  };
  for (const double position_m : report.camera_in_landmark.position_m) add(position_m * kMmPerM, kLengthDigits);
  for (const double q : report.camera_in_landmark.quaternion_wxyz) add(q, kQuaternionDigits);
  for (const double angle_rad : {report.swing_psi_rad, report.tilt_phi_rad, report.pan_theta_rad})
    add(angle_rad * kDegPerRad, kLengthDigits);
  add(report.distance_m * kMmPerM, kLengthDigits);
  for (std::size_t axis = 0; axis < 3; ++axis) add(std::sqrt(variance(report, axis)) * kMmPerM, kLengthDigits);
  add(std::sqrt(variance(report, 3) + variance(report, 4) + variance(report, 5)) * kDegPerRad, kLengthDigits);
  add(report.ambiguity, 6);
  add(report.rms_px, 6);
  row += fmt::format(",{},{},{}", report.dots_used, report.occlusion_level, solver_name(report.solver));
  if (columns == PoseCsvColumns::kAll) add(static_cast<double>(report.process_time.count()) / 1000, 1);
  row += '\n';
  return row;
}

std::string format_tum_row(const Report& report) {
  EXPECTS(report.valid);
  const std::int64_t ns = to_ns(report.exposed_at);
  std::string row = fmt::format("{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000);
  const auto add = [&row](double value) {
    row += ' ';
    append(row, value, kQuaternionDigits);
  };
  for (const double position_m : report.camera_in_landmark.position_m) add(position_m);
  const auto& q = report.camera_in_landmark.quaternion_wxyz;
  for (const std::size_t i : {1U, 2U, 3U, 0U}) add(q[i]);
  row += '\n';
  return row;
}

}  // namespace ninedot
