#pragma once
/// Writes a recording: frames/NNNNNN.png, frames.csv, camera.yaml.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/posix/whole_file.h"
#include "ports/frame_source.h"

namespace ninedot {

/// At every moment the folder is a recording that can be read: pictures and camera.yaml appear whole (temporary name,
/// then renamed), and a picture's row is appended to frames.csv once the picture is there. When either fails, as on a
/// full disk, both are taken back, and what was recorded before stays. A folder in which nothing was recorded is
/// removed. Memory: allocates per frame; not for the frame loop. Threads: one caller.
class RecordingWriter {
 public:
  /// \param folder  made with its parents; must be empty if it exists
  /// \param camera_yaml  text of the calibration; empty = the camera is not calibrated, no file
  /// \param write_bytes  write(2), or what a test puts in its place
  /// \param with_zoom  of a camera that tells where its zoom stands: a column for that
  /// Throws StartupError, one line: kWrongUsage when the folder is not empty, kWorkFailed when it can't be written.
  RecordingWriter(const std::string& folder, std::string_view camera_yaml, WriteFunction write_bytes = write_to_disk,
                  bool with_zoom = false);
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// Pictures are numbered from 0; a number is left out for each frame that was lost before this one. A frame with
  /// colour becomes an RGB picture, read back with the very luma and, where RGB has it, the very colour of each pixel
  /// (rgb_from_ycbcr).
  /// \return  the number of the picture
  /// \error kIo with errno (ENOSPC: the disk is full); the recording is as it was before the call.
  Result<std::uint64_t> add(const FrameLease& lease);

  std::uint64_t frame_count() const noexcept { return frame_count_; }

 private:
  void make_folder();
  void remove_folder() noexcept;
  Result<std::size_t> append_row(std::string_view row) noexcept;
  Result<std::size_t> encode(const Frame& frame);

  std::string folder_;
  std::string first_made_;  ///< the outermost folder that did not exist before
  WriteFunction write_bytes_;
  bool with_zoom_;
  int csv_ = -1;
  std::int64_t csv_bytes_ = 0;
  std::uint64_t frame_count_ = 0;
  std::uint64_t next_number_ = 0;
  std::vector<std::uint8_t> rgb_, png_;
};

}  // namespace ninedot
