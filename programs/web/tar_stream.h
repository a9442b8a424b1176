#pragma once
/// A recording as a tar archive (POSIX.1-1988, ustar), made while it is read: nothing of it is ever on the disk.
#include <sys/types.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "drivers/posix/file_descriptor.h"

namespace ninedot {

/// camera.yaml, camera.json, ended.txt, frames.csv, and by its rows each picture with its report.
/// Memory: fixed, 10 kB with the rows that are read ahead. Threads: one; waits for the disk.
class TarStream {
 public:
  /// \param folder  of the recording \param name  of the folder within the archive, of 60 characters at most
  TarStream(const std::string& folder, std::string name);

  /// \return  bytes that were put into `to`, all of it but at the end; 0: the archive is whole; -1: a file is not
  /// there or became shorter, because the recording was deleted meanwhile
  ssize_t read(std::span<char> to);

 private:
  enum class Next : std::uint8_t { kFile, kEnd, kBroken };

  Next next_file();
  bool open_file(const std::string& file);
  bool next_number();
  void put_header(const std::string& file, std::uint64_t bytes, std::int64_t changed_s);

  struct CloseFile {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };

  FileDescriptor folder_;  // so that a folder that is renamed is read on
  const std::string name_;
  std::unique_ptr<std::FILE, CloseFile> rows_;
  std::size_t fixed_files_done_ = 0;
  std::uint64_t number_ = 0;
  bool report_is_next_ = false, is_over_ = false;
  FileDescriptor file_;
  std::uint64_t file_bytes_left_ = 0;
  std::size_t padding_bytes_ = 0;   // after the file, up to a whole block
  std::array<char, 1024> block_{};  // a header, zeros after a file, or the end
  std::size_t block_from_ = 0, block_to_ = 0;
};

}  // namespace ninedot
