#pragma once
/// A recording in a folder of its own below the system's temporary folder, removed at the end of the test.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace ninedot {

class TemporaryRecording {
 public:
  /// Pictures of 8 x 4 px, frames/000000.pgm and on, each filled with its number.
  explicit TemporaryRecording(int frame_count) {
    std::string pattern = (std::filesystem::temp_directory_path() / "ninedot-test-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
    std::filesystem::create_directory(path_ + "/frames");
    for (int i = 0; i < frame_count; ++i)
      write(picture(i).substr(path_.size() + 1), "P5 8 4 255\n" + std::string(32, static_cast<char>(i)));
  }
  ~TemporaryRecording() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryRecording(const TemporaryRecording&) = delete;
  TemporaryRecording& operator=(const TemporaryRecording&) = delete;

  const std::string& path() const { return path_; }
  std::string picture(int i) const {
    char name[32];
    std::snprintf(name, sizeof(name), "/frames/%06d.pgm", i);
    return path_ + name;
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ + "/" + name, std::ios::binary) << text;
  }

 private:
  std::string path_;
};

}  // namespace ninedot
