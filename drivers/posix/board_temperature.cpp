#include "drivers/posix/board_temperature.h"

#include <cstdio>
#include <limits>

namespace ninedot {

double read_board_temperature(const char* path) noexcept {
  std::FILE* file = std::fopen(path, "re");
  if (file == nullptr) return std::numeric_limits<double>::quiet_NaN();
  int millidegrees = 0;
  const bool read = std::fscanf(file, "%d", &millidegrees) == 1;
  std::fclose(file);
  return read ? millidegrees / 1000.0 : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace ninedot
