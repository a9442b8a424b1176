#pragma once
/// One recording of what the tap gives, with what was found in each picture beside it.
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "drivers/posix/whole_file.h"
#include "drivers/recording/recording_writer.h"
#include "drivers/tap/tap_reader.h"
#include "programs/web/recording_shelf.h"

namespace ninedot {

/// As RecordingWriter has it: readable at every moment, and gone where nothing was recorded in it.
/// Memory: allocates for each frame. Threads: one; waits for the disk.
class TapRecording {
 public:
  /// \param folder  a new one \param header  of the service that the frames are of
  /// Throws StartupError(kWorkFailed), one line: it can't be written.
  TapRecording(const std::string& folder, const TapHeader& header, WriteFunction write_bytes = write_to_disk);

  /// Numbers are left out for frames that came since the last one and are not given.
  /// \param copy  with a picture (contract) \return  bytes on the disk
  /// \error kIo with errno (ENOSPC: the disk is full); what was recorded before stays.
  Result<std::uint64_t> add(const TapCopy& copy);

  /// What there is so far, its name included.
  const ShelfEntry& entry() const noexcept { return entry_; }
  /// Nothing more comes. \param why  one line, for people
  /// \return  nothing: there was no frame, and now there is no folder
  std::optional<ShelfEntry> end(std::string_view why);

 private:
  Result<std::uint64_t> write(const std::string& name, std::string_view text);

  std::string folder_;
  std::string camera_json_;
  WriteFunction write_bytes_;
  std::optional<RecordingWriter> writer_;
  ShelfEntry entry_;
  std::uint64_t publication_ = 0;
  std::int64_t first_ns_ = 0;  // exposure of the first frame
};

}  // namespace ninedot
