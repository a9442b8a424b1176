#pragma once
/// Which board this is, as its firmware tells the kernel.
#include <string>

namespace ninedot {

struct BoardIdentity {
  std::string model;   ///< "Raspberry Pi 4 Model B Rev 1.5"; empty: not told
  std::string serial;  ///< "10000000a1b2c3d4"; empty: not told, or not to this user
};

/// From the device tree, or else from DMI: the system's serial number, or the main board's. Reads files: not for the
/// frame path. \param sys  where sysfs is; a test's own \return  printable ASCII alone; what fills a field for want of
/// a number ("To Be Filled By O.E.M.") counts as not told Memory: allocates. Threads: any.
BoardIdentity read_board_identity(const std::string& sys = "/sys");

}  // namespace ninedot
