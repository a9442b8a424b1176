#pragma once
/// Frames of a tap as tests make them up, and a folder for what becomes of them.
#include <stdlib.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "programs/web/frame_queue.h"

namespace ninedot {

/// A folder of its own in memory, removed at the end.
class MemoryFolder {
 public:
  MemoryFolder() {
    std::string name = "/dev/shm/ninedot-recordings-test-XXXXXX";
    path_ = ::mkdtemp(name.data());
  }
  ~MemoryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline std::string text_of_file(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// A service of 10 Hz whose pictures are 32 x 16 px, each of one grey: its number.
class MadeUpService {
 public:
  static constexpr std::int64_t kPeriod_ns = 100'000'000;

  MadeUpService() {
    auto header = std::make_shared<TapHeader>();
    header->width_px = 32;
    header->height_px = 16;
    header->rate_hz = 10;
    header->intrinsics_px = {30, 30, 15.5, 7.5};
    header_ = header;
  }

  QueuedFrame next(bool is_valid = true) {
    QueuedFrame frame;
    frame.header = header_;
    frame.copy.publication = ++publication_;
    TapFrame& told = frame.copy.frame;
    told.number = publication_;
    told.exposed_at_ns = told.published_at_ns = static_cast<std::int64_t>(publication_) * kPeriod_ns;
    told.flags = is_valid ? tap_flag::kValid : 0;
    told.picture.width_px = told.picture.luma_stride_bytes = 32;
    told.picture.height_px = 16;
    told.picture.pixel_bytes = 32 * 16;
    frame.copy.pixels.assign(told.picture.pixel_bytes, static_cast<std::uint8_t>(publication_));
    return frame;
  }
  void skip(std::uint64_t frames) { publication_ += frames; }
  MonoTime now() const { return mono_from_ns(static_cast<std::int64_t>(publication_) * kPeriod_ns); }

 private:
  std::shared_ptr<const TapHeader> header_;
  std::uint64_t publication_ = 0;
};

}  // namespace ninedot
