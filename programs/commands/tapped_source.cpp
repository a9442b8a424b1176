#include "programs/commands/tapped_source.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "base/startup_error.h"
#include "programs/tap/tap_source.h"

namespace ninedot {
namespace {

std::string describe_tap_failure(const FrameSource& frames) {
  return static_cast<const TapSource&>(frames).last_failure();
}

}  // namespace

OpenedSource open_tapped_source(const std::string& config_file, const Config& config) {
  if (!config.tap.enabled)
    throw StartupError(ExitStatus::kWorkFailed,
                       config_file + ": no tap is configured: write `enabled = true` under [tap]");
  auto source = std::make_unique<TapSource>(config.tap.path);
  const auto width_px = static_cast<int>(source->header().width_px);
  const auto height_px = static_cast<int>(source->header().height_px);
  if (width_px != config.camera.width_px || height_px != config.camera.height_px)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("the service runs with pictures of {} x {} px, and {} says {} x {}: restart it",
                                   width_px, height_px, config_file, config.camera.width_px, config.camera.height_px));
  return {std::move(source), describe_tap_failure, {}, {}, 0, nullptr, false};
}

}  // namespace ninedot
