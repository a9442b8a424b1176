#include "programs/commands/own_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/mailbox.h"
#include "base/startup_error.h"
#include "drivers/modbus/tcp_server.h"
#include "drivers/posix/listening_program.h"
#include "drivers/posix/realtime.h"
#include "outputs/output_thread.h"
#include "programs/assembly/open_head.h"
#include "programs/commands/head_tour_drive.h"

namespace ninedot {
namespace {

/// The service's own first order would be to follow the landmark, by the numbers that are to be found.
Config without_following(Config config) {
  config.pan_tilt.follow = config.pan_tilt.search_at_start = false;
  return config;
}

/// A head with the thread that moves it.
class OwnHead final : public TouredHead {
 public:
  OwnHead(const Config& config, const CameraModel& camera, const std::shared_ptr<HeadLine>& line)
      : head_(open_head(without_following(config), camera, line, false)),
        priority_(std::max(0, config.service.realtime_priority - 1), "head") {
    thread_.emplace(reports_, *head_.output, priority_, HeadOutput::kPeriod);
  }
  /// No order reaches it any more, and it ends its motion; then its signals and its power go.
  ~OwnHead() override {
    thread_.reset();
    head_.servos->stop();
  }

  void go(const HeadAngles& goal) override { output_.go(goal); }
  State state(const Frame& frame) override {
    const State now = output_.state(frame);
    is_inhibited_ = now.is_inhibited;
    return now;
  }
  /// Of head, inhibit input or lamp.
  std::string problem() const override {
    for (const WatchedDevice& device : head_.devices) {
      // An input that is active keeps the head from being opened.
      if (is_inhibited_ && device.name == "pan/tilt") continue;
      if (std::string what = device.problem(); !what.empty()) return fmt::format("{}: {}", device.name, what);
    }
    return {};
  }

 private:
  OpenedHead head_;
  OutputHead output_{*head_.output};
  bool is_inhibited_ = false;
  Mailbox<Report> reports_;  // stays empty: nothing is followed
  RealtimeThread priority_;
  std::optional<OutputThread> thread_;
};

}  // namespace

void check_no_service(const ModbusTcpConfig& tcp) {
  if (!tcp.enabled || try_listen(tcp.listen, tcp.port) || find_listener("ninedotd", tcp.port) == Listening::kNo) return;
  throw StartupError(ExitStatus::kWorkFailed,
                     fmt::format("port {} is a running ninedotd's, which moves the head: --tap moves it through that, "
                                 "or stop it first (systemctl stop ninedotd)",
                                 tcp.port));
}

std::unique_ptr<TouredHead> open_own_head(const Config& config, const CameraModel& camera,
                                          const std::shared_ptr<HeadLine>& line) {
  return std::make_unique<OwnHead>(config, camera, line);
}

}  // namespace ninedot
