#include "programs/web/live_feed.h"

#include <fmt/format.h>

#include "base/json_text.h"
#include "base/startup_error.h"
#include "programs/web/live_json.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// How often a service that is not there is looked for.
constexpr auto kLookPeriod = 1s;

}  // namespace

void LiveFeed::look_for_service(MonoTime now) {
  if (tap_ && !tap_->is_alive()) {
    tap_.reset();
    problem_ = path_ + ": the service behind this tap has ended: start ninedotd";
  }
  if (tap_ || (looked_at_ != MonoTime{} && now - looked_at_ < kLookPeriod)) return;
  looked_at_ = now;
  try {
    tap_.emplace(path_);
    copy_.publication = service_seen_ = 0;
    demand_ = TapDemand::kNothing;
    problem_.clear();
  } catch (const StartupError& error) {
    problem_ = error.what();
  }
}

void LiveFeed::encode_picture() {
  jpeg_.clear();
  if (copy_.luma().empty()) return;
  if (const auto file = encoder_.encode(copy_.luma(), copy_.chroma(), quality_))
    jpeg_.assign(reinterpret_cast<const char*>(file->data()), file->size());
}

std::shared_ptr<const LiveMessage> LiveFeed::next(MonoTime now, TapDemand demand) {
  look_for_service(now);
  auto message = std::make_shared<LiveMessage>();
  message->number = ++number_;
  if (!tap_) {
    message->json = fmt::format(R"({{"number":{},"problem":{}}})", number_, json_text(problem_));
    return message;
  }
  if (demand_ != demand) {
    tap_->announce(demand);
    // What was copied before a rest is not of now.
    if (demand_ == TapDemand::kNothing) copy_.publication = service_seen_ = 0;
    demand_ = demand;
  }
  const bool is_new = tap_->copy_newest(copy_);
  if (is_new) encode_picture();
  tap_->copy_newest(service_seen_, service_);
  message->json = fmt::format(R"({{"number":{},"fresh":{},"camera":{})", number_, is_new, camera_json(tap_->header()));
  if (copy_.publication != 0) message->json += ",\"frame\":" + frame_json(copy_.frame, now);
  if (service_seen_ != 0) message->json += ",\"service\":" + service_json(service_, now);
  message->json += '}';
  if (is_new) message->jpeg = jpeg_;
  return message;
}

bool LiveFeed::has_newer() const noexcept { return tap_ && tap_->has_newer(copy_); }

void LiveFeed::rest() noexcept {
  if (tap_ && demand_ != TapDemand::kNothing) tap_->announce(TapDemand::kNothing);
  demand_ = TapDemand::kNothing;
}

}  // namespace ninedot
