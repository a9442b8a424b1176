#pragma once
/// Poses as text: the CSV of `ninedot replay --out`, and the TUM trajectory format that evaluation tools read.
///
/// CSV: a header, then one row for each landmark that was found in a frame. mm and degrees; the pose is that of the
/// camera in the landmark's frame S0, the quaternion rotates camera vectors into it (w >= 0).
///
/// | column | unit | what |
/// |---|---|---|
/// | frame | | the recording's frame number |
/// | timestamp_ns | ns | middle of the exposure, on the recording's clock |
/// | landmark_id | | 0 for the black-and-white landmark unless configured |
/// | x_mm y_mm z_mm | mm | optical centre |
/// | qw qx qy qz | | orientation |
/// | psi_deg phi_deg theta_deg | deg | swing, tilt and pan of the founding paper |
/// | distance_mm | mm | from the middle of P9 to the optical centre |
/// | sigma_x_mm sigma_y_mm sigma_z_mm | mm | 1-sigma of x, y, z |
/// | sigma_rot_deg | deg | 1-sigma of the rotation's angle: root of the sum of its three variances |
/// | ambiguity | | odds that another reading (mirror image, numbering) is the right one, 0..1 |
/// | rms_px | px | residual |
/// | dots | | dots used, of nine |
/// | occlusion_level | | 0 nothing hidden, 1..3 as in the founding paper |
/// | solver | | full, ellipse |
/// | process_us | us | time that detection and pose took: the one column that differs between two runs |
/// | valid | | 1, or 0: found, but not to be acted on; such a row counts as no answer |
/// | reason | | why not, a number of base/reason.h (docs/registers.md); 0 where valid |
/// | rival_odds | | odds of the second-likeliest reading; 0: there is none, and the columns after it are empty |
/// | rival_x_mm rival_y_mm rival_z_mm rival_qw rival_qx rival_qy rival_qz | mm | its pose |
/// | sigma_calibration_mm | mm | what of sigma_x, y, z together is the calibration's; empty: it does not say |
///
/// The text depends on the report alone (no locale, no "-0"): equal reports give equal bytes.
#include <string>
#include <string_view>

#include "proto/wire_report.h"

namespace ninedot {

enum class PoseCsvColumns {
  kAll,
  kWithoutTime,  ///< no process_us, so that two runs over the same recording give the same bytes
};

/// First line, with its line feed.
std::string_view pose_csv_header(PoseCsvColumns columns = PoseCsvColumns::kAll) noexcept;

/// One row with its line feed. \param report  of a frame that shows a landmark (WireReport::has_pose; contract)
std::string format_pose_csv_row(const WireReport& report, PoseCsvColumns columns = PoseCsvColumns::kAll);

/// "timestamp tx ty tz qx qy qz qw" with its line feed: s, m. Sturm et al., "A benchmark for the evaluation of RGB-D
/// SLAM systems", IROS 2012. \param report  of a frame that shows a landmark (contract)
std::string format_tum_row(const WireReport& report);

}  // namespace ninedot
