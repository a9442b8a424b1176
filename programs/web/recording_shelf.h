#pragma once
/// The folder in which ninedot-web keeps its recordings: what is there, how much it takes, what goes.
///
/// Beside what every recording has (frames/, frames.csv, camera.yaml), each holds reports/NNNNNN.json, what was found
/// in the picture of that number; camera.json, what is constant; ended.txt, one line: why it ended.
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/posix/file_descriptor.h"
#include "programs/web/recording_name.h"

namespace ninedot {

/// One recording, as people are told of it.
struct ShelfEntry {
  std::string name;
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;  ///< frames that came meanwhile and are not in it
  std::uint64_t bytes = 0;   ///< of all its files
  std::chrono::nanoseconds duration{};
  std::string ended;  ///< one line: why
};

/// Memory: one entry for each recording, kMost of them at most. Threads: one at a time; waits for the disk.
class RecordingShelf {
 public:
  static constexpr std::size_t kMost = 200;  ///< recordings, of both causes

  /// Makes the folder, and keeps others from using it as well. Recordings that no longer have an end, because the
  /// program or the machine went down, are made whole: a picture without its row is taken away, as is half a row, and
  /// what nothing was recorded in.
  /// Throws StartupError(kWorkFailed), one line: it can't be written, another process has it.
  explicit RecordingShelf(std::string folder);

  /// The oldest first.
  const std::vector<ShelfEntry>& entries() const noexcept { return entries_; }
  std::uint64_t bytes() const noexcept;
  bool is_full() const noexcept { return entries_.size() >= kMost; }

  std::string path_of(std::string_view name) const { return folder_ + "/" + std::string(name); }
  /// A name that no recording has, of now or of the next second in which it is free and the newest.
  std::string free_name(RecordingCause cause) const;
  /// What has been recorded under a free name: the newest, whatever the clock has done meanwhile.
  void add(ShelfEntry entry);
  /// From the list at once, from the disk before it returns. \return  false: there is none of this name
  bool remove(std::string_view name);
  /// Takes away the oldest of those that losses made. \return  false: there is none
  bool remove_oldest_loss();
  /// How many losses have made one. [1]
  std::size_t losses() const noexcept;

 private:
  std::string folder_;
  FileDescriptor lock_;
  std::vector<ShelfEntry> entries_;  // by age: as they were added, before them by name what was there at the start
};

}  // namespace ninedot
