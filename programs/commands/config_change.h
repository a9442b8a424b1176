#pragma once
/// A file that the service reads, replaced on trial: the one that it ran with is kept until the new one is known to
/// run.
///
///     FILE             configuration, or calibration of the camera: whole at every moment, the old or the new one
///     FILE.last-good   while a trial lasts: the old one; there afterwards: a trial was cut short
///     FILE.before      after a trial that went well: what FILE was before it
#include <string>
#include <string_view>

#include "drivers/posix/file_descriptor.h"
#include "drivers/posix/whole_file.h"

namespace ninedot {

/// Longest file that is applied: ten times the configuration of a hall of landmarks, 256 kB.
inline constexpr std::size_t kMaxApplied_bytes = std::size_t{256} * 1024;

/// One apply at a time on a machine, whoever starts it: a lock on the configuration's folder, which ends with the
/// process. Threads: one.
class ApplyLock {
 public:
  /// Throws StartupError: kWrongUsage, there is no such configuration; kWorkFailed, another apply is under way.
  explicit ApplyLock(const std::string& config_path);

 private:
  FileDescriptor folder_;
};

/// Whoever has one has the ApplyLock as well.
/// All of it throws StartupError with one line: kWrongUsage, FILE is none that can be replaced; kWorkFailed, the disk
/// is full, the folder can't be written. What was there then still is.
/// Memory: the text twice. Threads: one; waits for the disk.
class ConfigChange {
 public:
  /// \param path  may be a link: it stays one \param write_bytes  for tests of a full disk
  explicit ConfigChange(const std::string& path, WriteFunction write_bytes = write_to_disk);

  /// FILE; no link.
  const std::string& path() const noexcept { return path_; }
  /// Of FILE, as it was before `put`.
  const std::string& text() const noexcept { return text_; }
  /// What `put_back` brings: of FILE, or of FILE.last-good where a trial was cut short.
  const std::string& last_good() const noexcept { return last_good_; }
  /// An earlier trial was cut short: FILE has not been seen to run.
  bool was_cut_short() const noexcept { return was_cut_short_; }
  std::string before_path() const { return path_ + ".before"; }
  std::string last_good_path() const { return path_ + ".last-good"; }

  /// The new one into FILE, with its owner and mode; the old one into FILE.last-good.
  void put(std::string_view text);
  /// It runs: FILE.last-good becomes FILE.before.
  void confirm();
  /// It does not: FILE.last-good becomes FILE again. Needs no room on the disk.
  void put_back();

 private:
  FileReplacement written_beside(const std::string& path, std::string_view text) const;

  std::string path_;
  WriteFunction write_bytes_;
  std::string text_, last_good_;
  bool was_cut_short_ = false;
};

}  // namespace ninedot
