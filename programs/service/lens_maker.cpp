#include "programs/service/lens_maker.h"

#include <fmt/format.h>
#include <pthread.h>

#include <chrono>
#include <optional>

#include "programs/assembly/zoom_choice.h"

namespace ninedot {
namespace {

/// How often the thread looks whether it is to end.
constexpr std::chrono::milliseconds kLook{100};

}  // namespace

LensMaker::LensMaker(const ZoomTable& zoom, const LocaliserOptions& options, LensExchange& lenses, ServiceLog& log)
    : zoom_(zoom), options_(options), lenses_(lenses), log_(log) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void LensMaker::take(const Report& /*newest*/, bool /*is_new*/, MonoTime /*now*/) {
  std::vector<std::string> lines;
  {
    const std::lock_guard lock(mutex_);
    lines.swap(lines_);
  }
  for (const std::string& line : lines) log_.write(line);
}

void LensMaker::run(const std::stop_token& stop) {
  ::pthread_setname_np(::pthread_self(), "lenses");
  std::optional<int> made;
  while (!stop.stop_requested()) {
    const std::optional<int> wish = lenses_.wait_for_wish(made, mono_now() + kLook);
    if (!wish) continue;
    made = wish;
    std::string line = make(*wish);
    const std::lock_guard lock(mutex_);
    lines_.push_back(std::move(line));
  }
}

/// \return  what is to be said of it
std::string LensMaker::make(int zoom) {
  const std::optional<ZoomLens> lens = zoom_.at(zoom);
  if (!lens) return fmt::format("zoom {}: out of the calibration's reach, {}", zoom, zoom_.reach());
  lenses_.put(make_lens(*lens, options_));
  return fmt::format("zoom {}: f = {:.1f} px", zoom, lens->camera.fx_px);
}

}  // namespace ninedot
