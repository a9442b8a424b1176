#include "proto/pose_csv.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "base/contract.h"

namespace ninedot {
namespace {

constexpr double kMmPerM = 1000;
/// mm and deg to 1e-6, quaternions to 1e-9 (2e-9 rad): a thousandth of the best 1-sigma of one frame, and short to
/// read.
constexpr int kLengthDigits = 6;
constexpr int kQuaternionDigits = 9;

#define NINEDOT_CSV_POSE                                                                             \
  "frame,timestamp_ns,landmark_id,x_mm,y_mm,z_mm,qw,qx,qy,qz,psi_deg,phi_deg,theta_deg,distance_mm," \
  "sigma_x_mm,sigma_y_mm,sigma_z_mm,sigma_rot_deg,ambiguity,rms_px,dots,occlusion_level,solver"
#define NINEDOT_CSV_VERDICT                                                                                          \
  ",valid,reason,rival_odds,rival_x_mm,rival_y_mm,rival_z_mm,rival_qw,rival_qx,rival_qy,rival_qz,sigma_calibration_" \
  "mm\n"
constexpr std::string_view kHeader = NINEDOT_CSV_POSE ",process_us" NINEDOT_CSV_VERDICT;
constexpr std::string_view kHeaderWithoutTime = NINEDOT_CSV_POSE NINEDOT_CSV_VERDICT;
#undef NINEDOT_CSV_POSE
#undef NINEDOT_CSV_VERDICT

/// Fixed-point text; what rounds to zero has no sign.
void append(std::string& text, double value, int digits) {
  const std::size_t start = text.size();
  fmt::format_to(std::back_inserter(text), "{:.{}f}", value, digits);
  if (text[start] == '-' && text.find_first_of("123456789n", start) == std::string::npos) text.erase(start, 1);
}

}  // namespace

std::string_view pose_csv_header(PoseCsvColumns columns) noexcept {
  return columns == PoseCsvColumns::kAll ? kHeader : kHeaderWithoutTime;
}

std::string format_pose_csv_row(const WireReport& report, PoseCsvColumns columns) {
  EXPECTS(report.has_pose);
  std::string row = fmt::format("{},{},{}", report.frame_number, to_ns(report.exposed_at), report.landmark_id);
  const auto add = [&row](double value, int digits) {
    row += ',';
    append(row, value, digits);
  };
  for (const double position_mm : report.camera_in_landmark.position_mm) add(position_mm, kLengthDigits);
  for (const double q : report.camera_in_landmark.quaternion_wxyz) add(q, kQuaternionDigits);
  for (const double angle_deg : {report.swing_psi_deg, report.tilt_phi_deg, report.pan_theta_deg})
    add(angle_deg, kLengthDigits);
  add(report.distance_mm, kLengthDigits);
  for (const double sigma_mm : report.sigma_landmark_mm) add(sigma_mm, kLengthDigits);
  add(report.sigma_rotation_deg, kLengthDigits);
  add(report.ambiguity, 6);
  add(report.rms_px, 6);
  row += fmt::format(",{},{},{}", report.dots_used, report.occlusion_level, report.ellipse_solver ? "ellipse" : "full");
  if (columns == PoseCsvColumns::kAll) add(report.process_us, 1);
  row += fmt::format(",{:d},{}", report.valid, static_cast<unsigned>(report.reason));
  add(report.rival_odds, 6);
  if (report.rival_odds > 0) {
    for (const double position_mm : report.rival_in_landmark.position_mm) add(position_mm, kLengthDigits);
    for (const double q : report.rival_in_landmark.quaternion_wxyz) add(q, kQuaternionDigits);
  } else {
    row.append(7, ',');
  }
  if (std::isfinite(report.sigma_calibration_landmark_mm))
    add(report.sigma_calibration_landmark_mm, kLengthDigits);
  else
    row += ',';
  row += '\n';
  return row;
}

std::string format_tum_row(const WireReport& report) {
  EXPECTS(report.valid);
  const std::int64_t ns = to_ns(report.exposed_at);
  std::string row = fmt::format("{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000);
  const auto add = [&row](double value) {
    row += ' ';
    append(row, value, kQuaternionDigits);
  };
  for (const double position_mm : report.camera_in_landmark.position_mm) add(position_mm / kMmPerM);
  const auto& q = report.camera_in_landmark.quaternion_wxyz;
  for (const std::size_t i : {1U, 2U, 3U, 0U}) add(q[i]);
  row += '\n';
  return row;
}

}  // namespace ninedot
