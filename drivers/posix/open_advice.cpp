#include "drivers/posix/open_advice.h"

#include <grp.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

namespace ninedot {

std::string open_advice(const std::string& path, int error) {
  if (error == ENOENT) return path + ": no such device or file";
  if (error == EBUSY) return path + ": in use by another program: stop it";
  struct stat status {};
  if (error != EACCES || ::stat(path.c_str(), &status) != 0) return path + ": " + std::strerror(error);
  const group* const entry = ::getgrgid(status.st_gid);
  const std::string name = entry != nullptr ? entry->gr_name : std::to_string(status.st_gid);
  return path + ": permission missing: it belongs to the group '" + name + "': join it, or let a udev rule open it";
}

}  // namespace ninedot
