#pragma once
/// What both versions of libgpiod need from the file system.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace ninedot {

/// "/dev/gpiochip0", ...; libgpiod's own lists end at the first chip that may not be opened.
inline std::vector<std::string> gpio_chip_paths() {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error))
    if (entry.path().filename().string().starts_with("gpiochip")) paths.push_back(entry.path().string());
  std::ranges::sort(paths);
  return paths;
}

}  // namespace ninedot
