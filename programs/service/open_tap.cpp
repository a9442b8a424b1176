#include "programs/service/open_tap.h"

#include <algorithm>
#include <string_view>

#include "base/mono_time.h"
#include "base/startup_error.h"
#include "programs/tap/tap_frame.h"

namespace ninedot {

OpenedTap open_tap(const Config& config, const CameraModel& camera, const LandmarkGeometry& landmark) {
  OpenedTap tap;
  if (!config.tap.enabled) return tap;
  TapHeader header;
  describe_camera(camera, landmark, header);
  constexpr std::string_view kVersion = NINEDOT_VERSION;
  static_assert(kVersion.size() < sizeof header.software);
  std::copy(kVersion.begin(), kVersion.end(), header.software.begin());
  header.started_at_ns = to_ns(mono_now());
  header.rate_hz = config.camera.rate_hz;
  try {
    tap.writer = std::make_unique<TapWriter>(config.tap.path, header);
    tap.observer = std::make_unique<TapObserver>(*tap.writer);
  } catch (const StartupError& error) {
    tap.refusal = error.what();
  }
  return tap;
}

}  // namespace ninedot
