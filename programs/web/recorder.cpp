#include "programs/web/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "base/startup_error.h"
#include "programs/web/frame_taker.h"
#include "programs/web/recorder_json.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// How often pages may find the state changed.
constexpr auto kTellPeriod = 200ms;
// The thread that writes looks at its clock as often while no frame comes.
constexpr auto kTick = 100ms;
// Where nothing is wanted it is woken.
constexpr auto kAnHour = 1h;

void log_line(const std::string& text) { fmt::print(stderr, "ninedot-web: recordings: {}\n", text); }

}  // namespace

RecorderOptions recorder_options(const Config& config, bool has_token) {
  const WebConfig& web = config.web;
  RecorderOptions options;
  if (web.recordings.empty())
    options.why_not =
        "Nothing is recorded: `recordings` of [web] names no folder, \"/var/lib/ninedot-web\" for instance.";
  options.tap_path = config.tap.path;
  options.folder = web.recordings;
  options.may_ask = has_token;
  options.rules.most_bytes = std::uint64_t{1'000'000} * static_cast<std::uint64_t>(web.recordings_mb);
  options.rules.longest = std::chrono::seconds(web.recording_s);
  options.rules.loss.before =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(web.loss_seconds));
  options.rules.most_losses = static_cast<std::size_t>(web.losses);
  return options;
}

Recorder::Recorder(RecorderOptions options) : options_(std::move(options)) {
  if (!options_.why_not.empty()) return;
  try {
    shelf_ = std::make_unique<RecordingShelf>(options_.folder);
  } catch (const StartupError& error) {
    options_.why_not = error.what();
    log_line(error.what());
    return;
  }
  desk_ = std::make_unique<RecordingDesk>(options_.rules, *shelf_, log_line);
  publish();
  taker_ = std::thread([this] { take_frames(); });
  writer_ = std::thread([this] { write_frames(); });
}

Recorder::~Recorder() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  demand_.notify_all();
  queue_.wake();
  if (taker_.joinable()) taker_.join();
  if (writer_.joinable()) writer_.join();
}

bool Recorder::has(std::string_view name) const {
  return std::any_of(state_.entries.begin(), state_.entries.end(), [&](const ShelfEntry& e) { return e.name == name; });
}

std::string Recorder::json_of(std::string_view problem) const {
  RecordingState state = state_;
  // As it will be in a moment, or a page would see its button undone.
  if (wish_ == Wish::kStart) state.is_awaited = true;
  std::erase_if(state.entries, [&](const ShelfEntry& entry) {
    return std::find(doomed_.begin(), doomed_.end(), entry.name) != doomed_.end();
  });
  return recordings_json(state, {options_.why_not, options_.may_ask, wish_ == Wish::kStop, problem});
}

RecorderReply Recorder::refused(unsigned status, const std::string& why) const { return {status, json_of(why)}; }

RecorderReply Recorder::reply_to(std::string_view text) {
  constexpr std::string_view kDelete = "delete ";
  const std::lock_guard lock(mutex_);
  const bool is_running = state_.running || state_.is_awaited || wish_ == Wish::kStart;
  if (text == "start") {
    if (!options_.why_not.empty()) return refused(409, options_.why_not);
    if (is_running) return refused(409, "A recording is being made already: stop it first.");
    wish_ = Wish::kStart;
  } else if (text == "stop") {
    if (!is_running) return refused(409, "No recording is being made.");
    wish_ = Wish::kStop;
  } else if (text.starts_with(kDelete) && is_recording_name(text.substr(kDelete.size()))) {
    const std::string_view name = text.substr(kDelete.size());
    if (!has(name)) return refused(404, "There is no such recording, or it is not over yet.");
    if (doomed_.size() >= kMostDeletions) return refused(409, "Others are being deleted: try again in a moment.");
    doomed_.emplace_back(name);
  } else {
    return refused(400, "Ask for: start, stop, delete NAME.");
  }
  queue_.wake();
  return {200, json_of({})};
}

std::string Recorder::state_json() const {
  const std::lock_guard lock(mutex_);
  return json_of({});
}

std::string Recorder::folder_of(std::string_view name) const {
  const std::lock_guard lock(mutex_);
  return has(name) ? options_.folder + "/" + std::string(name) : std::string();
}

void Recorder::take_frames() {
  FrameTaker taker(options_.tap_path, queue_);
  std::unique_lock lock(mutex_);
  while (!ending_) {
    const bool wants = wants_frames_;
    lock.unlock();
    const auto pause = wants ? taker.look(mono_now()) : taker.rest();
    lock.lock();
    trouble_ = taker.trouble();
    demand_.wait_for(lock, pause, [&] { return ending_ || wants_frames_ != wants; });
  }
}

void Recorder::carry_out_wishes() {
  Wish wish = Wish::kNone;
  std::vector<std::string> doomed;
  {
    const std::lock_guard lock(mutex_);
    wish = wish_;
    doomed = doomed_;
  }
  if (wish == Wish::kNone && doomed.empty()) return;
  if (wish == Wish::kStart) desk_->start(mono_now());
  if (wish == Wish::kStop) desk_->stop("stopped by hand");
  for (const std::string& name : doomed) desk_->remove(name);
  {
    const std::lock_guard lock(mutex_);
    if (wish_ == wish) wish_ = Wish::kNone;
    doomed_.erase(doomed_.begin(), doomed_.begin() + static_cast<std::ptrdiff_t>(doomed.size()));
    state_ = desk_->state();
  }
  publish();
}

void Recorder::publish() {
  RecordingState state = desk_->state();
  {
    const std::lock_guard lock(mutex_);
    std::swap(state_, state);
    wants_frames_ = desk_->wants_frames();
  }
  demand_.notify_all();
}

void Recorder::write_frames() {
  QueuedFrame frame;
  MonoTime told_at{};
  for (;;) {
    carry_out_wishes();
    const bool has_more = desk_->save_one();
    std::string trouble;
    {
      const std::lock_guard lock(mutex_);
      if (ending_) break;
      trouble = trouble_;
    }
    const bool sleeps = !has_more && !desk_->wants_frames();
    const MonoTime now = mono_now();
    if (queue_.pop(frame, sleeps ? now + kAnHour : has_more ? now : now + kTick))
      desk_->take(frame, mono_now());
    else
      desk_->wait(mono_now(), trouble);
    // Where nothing is wanted any more the next round may be an hour off: what ended is told now.
    if (desk_->wants_frames() && mono_now() - told_at < kTellPeriod) continue;
    told_at = mono_now();
    publish();
  }
  desk_->close();
}

}  // namespace ninedot
