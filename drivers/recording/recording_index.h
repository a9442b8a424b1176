#pragma once
/// What a recording holds: its frames in order, with their times, before any picture is decoded.
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/picture/picture_file.h"

namespace ninedot {

/// Frames per second of a recording that carries no times: the default of camera.rate_hz.
inline constexpr double kUntimedRate_hz = 35;

struct RecordedFrame {
  std::uint64_t number = 0;                ///< NNNNNN of frames/NNNNNN.*; of a .y4m file 0, 1, 2, ...
  std::chrono::nanoseconds recorded_at{};  ///< frames.csv; else number / rate
  double pan_rad = 0, tilt_rad = 0;        ///< frames.csv, else 0
  std::string file;                        ///< the picture's path, there or not; empty in a .y4m file
  std::int64_t offset_bytes = 0;           ///< of the luma plane in a .y4m file; -1 = its frame header is damaged
  std::optional<int> zoom = {};            ///< frames.csv [steps]; none: not known
};

struct RecordingIndex {
  std::string path;  ///< of the folder or the .y4m file
  bool is_y4m = false;
  PictureSize size;                    ///< of the first picture whose header can be read
  PictureSize y4m_chroma_size;         ///< of each colour plane in a .y4m file; 0 x 0: it has none
  std::size_t largest_file_bytes = 0;  ///< of the pictures; 0 with .y4m
  std::vector<RecordedFrame> frames;   ///< at least one; numbers and times grow

  /// Of a zoom camera: a frame at least says where its zoom stood.
  bool tells_zoom() const;
};

/// Reads the index of a folder with frames/NNNNNN.(png|pgm|ppm|jpg|jpeg) or of a .y4m file.
///
/// With frames.csv its rows are the recording, and a picture beside them is an error. Without it the numbers must
/// follow each other: a number that is left out stands for a missing picture, found out when its turn comes. Throws
/// StartupError(kWorkFailed), one line that names the file: nothing to read, no picture, a damaged frames.csv, a file
/// that is far too long; StartupError(kWrongUsage): a fifo.
RecordingIndex read_recording_index(const std::string& path);

/// The calibration that belongs to a recording: camera.yaml in its folder, or beside the .y4m file. It may not exist.
std::string recording_camera_file(const std::string& path);

}  // namespace ninedot
