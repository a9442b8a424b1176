#pragma once
/// frames.csv of a recording: when each picture was exposed, and where the pan/tilt head looked.
///
///     frame,timestamp_ns,pan_deg,tilt_deg
///     0,0,0,0
///     1,28571429,0.25,-1.5
///
/// A zoom camera's has a further column, `zoom`: the position that it told, in its own steps; nothing in it: not known.
///
/// The header names the columns, in any order; `frame` and `timestamp_ns` must be there, `pan_deg` and `tilt_deg` may
/// be missing (then 0), and so may `zoom` (then not known). Both `frame` and `timestamp_ns` grow from row to row. Lines
/// end with LF or CR LF.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace ninedot {

struct FramesCsvRow {
  std::uint64_t frame = 0;        ///< number of the picture: frames/NNNNNN.*; below 10^9
  std::int64_t timestamp_ns = 0;  ///< middle of the exposure, >= 0, on any clock that does not jump
  double pan_deg = 0;             ///< positive to the left, -360..360
  double tilt_deg = 0;            ///< positive upwards, -360..360
  std::optional<int> zoom = {};   ///< [steps] 0..65535; none: not known
};

/// What is wrong with a text file, and where.
struct TextError {
  int line = 0;  ///< from 1
  std::string what;
};

inline constexpr std::string_view kFramesCsvHeader = "frame,timestamp_ns,pan_deg,tilt_deg\n";
inline constexpr std::string_view kFramesCsvHeaderWithZoom = "frame,timestamp_ns,pan_deg,tilt_deg,zoom\n";

/// Strict: an unknown or repeated column, a number that is not one, a row that goes back in time is an error.
tl::expected<std::vector<FramesCsvRow>, TextError> parse_frames_csv(std::string_view text);

/// One row with its line feed. The shortest text that reads back to the same numbers. \param with_zoom  as the header
std::string format_frames_csv_row(const FramesCsvRow& row, bool with_zoom = false);

}  // namespace ninedot
