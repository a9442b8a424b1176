#pragma once
/// Files that are there whole or not at all: read into memory that the caller owns, and replaced so that no reader ever
/// sees half of one.
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "base/result.h"
#include "drivers/posix/file_descriptor.h"

namespace ninedot {

/// write(2), or what a test puts in its place to make the disk full. Returns the number of bytes written, or -1 and an
/// errno.
using WriteFunction = ssize_t (*)(int descriptor, const void* bytes, std::size_t count);
/// write(2) itself. \return  number of bytes, or -1 and an errno. Threads: any; may wait for the disk.
ssize_t write_to_disk(int descriptor, const void* bytes, std::size_t count) noexcept;

/// Of a pipe all that is written until its last writer closes it, however long that takes.
/// \return the number of bytes read; the file's end was reached.
/// \error kIo with errno; EFBIG when the file is longer than `buffer`; without an errno: a pipe that nobody has open to
/// write, nor opens within a second.
/// Memory: none. Threads: any; waits for the disk.
Result<std::size_t> read_whole_file(const char* path, std::span<std::uint8_t> buffer) noexcept;

/// All of `bytes` to an open descriptor. \return the number of bytes written. \error kIo with errno
/// Memory: none. Threads: any, one per descriptor; may wait for the disk.
Result<std::size_t> write_all(int descriptor, std::span<const std::uint8_t> bytes, WriteFunction write_bytes) noexcept;

/// Whether a file has to outlast a power cut right after it was written.
enum class Durability {
  /// The disk has it before anybody sees it: fsync of the file, then of the folder after the rename. For what a person
  /// would have to do again: settings, calibrations, maps, the sheet to print, a table of poses.
  kPowerCut,
  /// The kernel writes it when it sees fit (within some 30 s, vm.dirty_expire_centisecs): for the pictures of a
  /// recording, 35 a second, whose last seconds may be lost, and for overlays, which can be drawn again.
  kWhenConvenient,
};

/// A file in the folder of PATH which becomes PATH at `commit`; without it nothing is left behind and PATH is as it
/// was. It has no name until then, so that this holds for a program that is killed as well. Where the file system wants
/// a name (network file systems do), it has one of its own beside PATH that ends in .tmp. A link stays one, and what it
/// leads to is replaced. Things that are no regular files (/dev/null, a fifo) are written directly. All errors are kIo
/// with errno (EISDIR: PATH is a folder, ENOSPC: the disk is full).
/// Memory: two paths. Threads: one.
class FileReplacement {
 public:
  static Result<FileReplacement> begin(const std::string& path);
  FileReplacement(FileReplacement&& other) noexcept
      : file_(std::move(other.file_)),
        path_(std::move(other.path_)),
        temporary_(std::exchange(other.temporary_, std::string())),
        is_nameless_(other.is_nameless_),
        is_settled_(other.is_settled_) {}
  FileReplacement& operator=(FileReplacement&&) = delete;
  ~FileReplacement();

  /// With owner, group and mode of the file `model`, which others may have to read: else it is 0644 less the umask, of
  /// whoever writes it. \return  0 bytes \error kIo: there is no model; EPERM, not permitted
  Result<std::size_t> keep_rights(const std::string& model) noexcept;
  /// Appends all of `bytes`. \return  the number of bytes written
  Result<std::size_t> write(std::span<const std::uint8_t> bytes, WriteFunction write_bytes = write_to_disk) noexcept;
  /// Where several files belong together, before the first of them is committed: all that can fail for want of room has
  /// failed then. Nothing is written afterwards. \return  0 bytes
  Result<std::size_t> settle(Durability durability) noexcept;
  /// Once, at the end; settles what is not yet. \return  0 bytes: what was written is counted by `write`
  Result<std::size_t> commit(Durability durability) noexcept;

 private:
  FileReplacement() = default;

  FileDescriptor file_;
  std::string path_;
  std::string temporary_;  // empty: written directly, without a name yet, or committed
  bool is_nameless_ = false;
  bool is_settled_ = false;
};

/// FROM becomes TO in one step, which a power cut does not undo once this has returned. Needs no room on the disk.
/// \return  0 bytes \error kIo with errno
/// Memory: a path. Threads: any; waits for the disk.
Result<std::size_t> move_whole_file(const std::string& from, const std::string& to);

/// The three steps at once.
Result<std::size_t> write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes,
                                     Durability durability = Durability::kPowerCut,
                                     WriteFunction write_bytes = write_to_disk);

}  // namespace ninedot
