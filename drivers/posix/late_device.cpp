#include "drivers/posix/late_device.h"

#include <cerrno>

namespace ninedot {

void refuse_device(const std::string& line, int error) {
  if (error == ENOTTY || error == EINVAL || error == EISDIR || error == ENOTDIR || error == ENAMETOOLONG ||
      error == ELOOP)
    throw StartupError(ExitStatus::kWrongUsage, line);
  throw DeviceAbsent(line);
}

}  // namespace ninedot
