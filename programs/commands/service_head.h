#pragma once
/// The head of a running service, taken along a tour by commands like any client's.
#include "config/config.h"
#include "programs/commands/head_client.h"
#include "programs/commands/toured_head.h"

namespace ninedot {

/// A head that follows the landmark follows it again afterwards, however this process ends: the service's watchdog sees
/// to that. Any other stays where it is then. Each call throws StartupError(kWorkFailed): the service is gone, or
/// another client has taken the head, which it keeps.
class ServiceHead final : public TouredHead {
 public:
  /// \param config  the service's
  /// Throws StartupError(kWorkFailed) as HeadClient does, and where a controller has the head.
  explicit ServiceHead(const Config& config);
  ~ServiceHead() override;

  void go(const HeadAngles& goal) override;
  /// \param frame  of the service's tap, which has the head's angles
  State state(const Frame& frame) override;

 private:
  void give_back();

  HeadClient client_;
  bool follows_ = false;  // before this, and afterwards
};

}  // namespace ninedot
