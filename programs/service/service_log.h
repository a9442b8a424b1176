#pragma once
/// The few lines that the service writes while it runs: what changed, not what is.
#include <cstdint>
#include <string>

#include "base/result.h"
#include "report/report.h"

namespace ninedot {

class LiveDisplay;

/// Threads: one caller.
class ServiceLog {
 public:
  /// \param display  makes room on the terminal before each line; may be null.
  explicit ServiceLog(LiveDisplay* display = nullptr) : display_(display) {}

  /// One line to standard error: "ninedotd: LINE".
  void write(const std::string& line);

  /// Says when the landmark comes and goes and when the camera fails and recovers: a change that has lasted for
  /// kSettle (and the very first one at once), so that a landmark at the edge of sight does not fill the disk.
  void note(const Report& report, const Error& last_error, MonoTime now);

 private:
  static constexpr std::chrono::milliseconds kSettle{500};
  LiveDisplay* display_;
  Reason said_ = Reason::kStarting;
  Reason seen_ = Reason::kStarting;
  MonoTime seen_since_{};
};

}  // namespace ninedot
