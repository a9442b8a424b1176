#include "programs/commands/source_failure.h"

#include <fmt/format.h>

#include <chrono>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// A camera that gives no picture for so long will give none.
constexpr auto kPatience = 5s;

}  // namespace

std::string why_source_failed(const OpenedSource& source, const Error& error, MonoTime last_frame_at) {
  if (source.describe_failure != nullptr)
    if (std::string detail = source.describe_failure(*source.frames); !detail.empty()) return detail;
  if (mono_now() - last_frame_at <= kPatience) return {};
  return fmt::format("no frame for {} s: {}", kPatience.count(), error.text);
}

}  // namespace ninedot
