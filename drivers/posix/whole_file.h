#pragma once
/// Whole files in and out: reading into memory that the caller owns, and writing so that no reader ever sees half a
/// file.
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "base/result.h"

namespace ninedot {

/// write(2), or what a test puts in its place to make the disk full. Returns the number of bytes written, or -1 and an
/// errno.
using WriteFunction = ssize_t (*)(int descriptor, const void* bytes, std::size_t count);
/// write(2) itself. \return  number of bytes, or -1 and an errno. Threads: any; may wait for the disk.
ssize_t write_to_disk(int descriptor, const void* bytes, std::size_t count) noexcept;

/// \return the number of bytes read; the file's end was reached.
/// \error kIo with errno; EFBIG when the file is longer than `buffer`.
/// Memory: none. Threads: any; waits for the disk.
Result<std::size_t> read_whole_file(const char* path, std::span<std::uint8_t> buffer) noexcept;

/// Writes PATH.tmp and renames it to PATH; on failure PATH is as it was and PATH.tmp is gone.
/// Does not wait for the disk (fsync): for recordings, where losing the last second to a power cut is acceptable.
/// \return the number of bytes written.
/// \error kIo with errno (ENOSPC: the disk is full).
/// Memory: allocates the temporary name. Threads: any, for different paths; may wait for the disk.
Result<std::size_t> write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes,
                                     WriteFunction write_bytes = write_to_disk);

/// All of `bytes` to an open descriptor. \return the number of bytes written. \error kIo with errno
/// Memory: none. Threads: any, one per descriptor; may wait for the disk.
Result<std::size_t> write_all(int descriptor, std::span<const std::uint8_t> bytes, WriteFunction write_bytes) noexcept;

}  // namespace ninedot
