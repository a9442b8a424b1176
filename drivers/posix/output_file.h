#pragma once
/// A result file that is written piece by piece and is there whole or not at all.
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/posix/whole_file.h"

namespace ninedot {

/// A FileReplacement for text in pieces, made safe against a power cut at `finish`; without `finish` nothing is left
/// behind, also by whoever is killed (where the file system permits it: FileReplacement). Standard output (empty path
/// or "-") is written directly, as are things that are no regular files. Throws StartupError(kWorkFailed) with one
/// line: the file can't be made, the disk is full. Memory: allocates. Threads: one at a time; everything may wait for
/// the disk.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);

  void write(std::string_view text);
  void finish();
  /// All of them have their names, or none has where one can't be written. \param files  null: none
  friend void finish_together(std::initializer_list<OutputFile*> files);

 private:
  void flush();
  /// On the disk, but not yet under its name.
  void settle();
  /// \return  what it holds, or throws what it says
  template <typename T>
  T need(Result<T> result) const;

  std::string path_;
  std::optional<FileReplacement> file_;  // none: standard output
  std::string pending_;                  // not yet written
};

void finish_together(std::initializer_list<OutputFile*> files);

}  // namespace ninedot
