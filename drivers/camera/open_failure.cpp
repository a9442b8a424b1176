#include "drivers/camera/open_failure.h"

#include <fmt/format.h>
#include <grp.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

namespace ninedot {
namespace {

std::string group_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return "video";
  const group* const entry = ::getgrgid(status.st_gid);
  return entry != nullptr ? entry->gr_name : std::to_string(status.st_gid);
}

}  // namespace

std::string describe_open_failure(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return fmt::format("{}: no such camera: connect it, or choose one that `ninedot cameras` lists", path);
    case EACCES:
    case EPERM:
      return fmt::format(
          "{0}: permission missing: it belongs to the group '{1}': usermod -aG {1} USER, then log in anew", path,
          group_of(path));
    case EBUSY:
      return fmt::format("{0}: busy: stop the program that uses it (fuser {0} names it)", path);
    default:
      return fmt::format("{}: {}", path, std::strerror(error));
  }
}

}  // namespace ninedot
