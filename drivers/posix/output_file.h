#pragma once
/// A result file that is there whole or not at all.
#include <cstdio>
#include <string>
#include <string_view>

namespace ninedot {

/// Writes PATH.tmp beside the wanted file and renames it at `finish`; without `finish` nothing is left behind. Standard
/// output (empty path or "-") and things that are no regular files (/dev/null, a fifo) are written directly.
/// Throws StartupError(kWorkFailed) with one line: the file can't be made, the disk is full.
/// Memory: allocates. Threads: one at a time; everything may wait for the disk.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void finish();

 private:
  [[noreturn]] void fail(const char* what) const;

  std::string path_;
  std::string temporary_path_;  // empty: written directly
  std::FILE* file_ = nullptr;
};

}  // namespace ninedot
