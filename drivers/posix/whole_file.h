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

/// write(2), or what a test puts in its place to make the disk full.
using WriteFunction = ssize_t (*)(int descriptor, const void* bytes, std::size_t count);
ssize_t write_to_disk(int descriptor, const void* bytes, std::size_t count) noexcept;

/// \return the number of bytes read; the file's end was reached.
/// \error kIo with errno; EFBIG when the file is longer than `buffer`.
/// Memory: none.
Result<std::size_t> read_whole_file(const char* path, std::span<std::uint8_t> buffer) noexcept;

/// Writes PATH.tmp and renames it to PATH; on failure PATH is as it was and PATH.tmp is gone.
/// Does not wait for the disk (fsync): for recordings, where losing the last second to a power cut is acceptable.
/// \error kIo with errno (ENOSPC: the disk is full).
Result<std::size_t> write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes,
                                     WriteFunction write_bytes = write_to_disk);

/// All of `bytes` to an open descriptor. \error kIo with errno
Result<std::size_t> write_all(int descriptor, std::span<const std::uint8_t> bytes, WriteFunction write_bytes) noexcept;

}  // namespace ninedot
