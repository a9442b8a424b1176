#pragma once
/// A device that may come late, or go and come back, as the log sees it.
#include <functional>
#include <string>

namespace ninedot {

/// Must not outlive what its functions ask. Threads: any may call them.
struct WatchedDevice {
  std::string name;                          ///< "inhibit input"
  std::function<std::string()> problem;      ///< why it is not in use; empty: it is
  std::function<std::string()> description;  ///< what there is to say about it while it is in use; may be null
};

}  // namespace ninedot
