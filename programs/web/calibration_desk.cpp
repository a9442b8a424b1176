#include "programs/web/calibration_desk.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "base/json_text.h"
#include "base/startup_error.h"
#include "drivers/posix/child_program.h"
#include "drivers/posix/text_file.h"
#include "programs/web/access.h"
#include "programs/web/jogger.h"
#include "programs/web/recording_name.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kLook = 200ms;
constexpr std::string_view kCalibration = "camera.yaml", kPicture = "camera.svg", kHeadFile = "head.toml";
constexpr std::string_view kUse = "use ";

/// The oldest first.
std::vector<fs::path> kept_in(const fs::path& folder) {
  std::vector<fs::path> kept;
  std::error_code error;
  for (fs::directory_iterator place(folder, error), end; !error && place != end; place.increment(error))
    if (is_time_name(place->path().filename().string())) kept.push_back(place->path());
  std::ranges::sort(kept);
  return kept;
}

std::string limits_of(const HeadAxisConfig& axis) {
  return fmt::format(R"({{"min":{},"max":{}}})", axis.min_deg, axis.max_deg);
}

std::string_view state_of(std::string_view line) {
  constexpr std::string_view kStart = R"({"state":")";
  if (!line.starts_with(kStart)) return {};
  line.remove_prefix(kStart.size());
  return line.substr(0, line.find('"'));
}

}  // namespace

CalibrationDeskOptions calibration_desk_options(const Config& config, const std::string& config_path,
                                                const std::string& program, bool has_token) {
  CalibrationDeskOptions options;
  options.program = program, options.config_path = config_path, options.has_token = has_token;
  options.calibration = config.camera.calibration;
  options.folder = config.web.recordings + "/calibrations";
  options.no_head = why_no_head(config, has_token);
  options.limits =
      fmt::format(R"({{"pan":{},"tilt":{}}})", limits_of(config.pan_tilt.pan), limits_of(config.pan_tilt.tilt));
  if (config.web.recordings.empty())
    options.why_not =
        "There is no place for a calibration: set `recordings` of [web], to \"/var/lib/ninedot-web\" for instance.";
  else if (!has_token)
    options.why_not = "Without a token nothing can be calibrated: set `token_file` of [web].";
  return options;
}

CalibrationDesk::CalibrationDesk(CalibrationDeskOptions options, ApplyRequest& request,
                                 std::chrono::nanoseconds unheard)
    : options_(std::move(options)), request_(request), unheard_(unheard) {}

CalibrationDesk::~CalibrationDesk() {
  {
    const std::lock_guard lock(mutex_);
    if (child_ > 0) ::kill(child_, SIGKILL);
  }
  if (thread_.joinable()) thread_.join();
}

DeskReply CalibrationDesk::reply_to(std::string_view text) {
  if (!options_.why_not.empty()) return {403, options_.why_not + "\n"};
  if (text == "start camera") return start(false);
  if (text == "start pan-tilt") return options_.no_head.empty() ? start(true) : DeskReply{403, options_.no_head + "\n"};
  if (text == "finish") return signal_child(SIGINT, Phase::kRunning);
  if (text == "cancel") return signal_child(SIGKILL, Phase::kCancelled);
  if (text.starts_with(kUse)) return use(text.substr(kUse.size()));
  return {400, "Say start camera, start pan-tilt, finish, cancel, or use and which one.\n"};
}

DeskReply CalibrationDesk::start(bool of_head) {
  const std::lock_guard one(one_at_a_time_);
  {
    const std::lock_guard lock(mutex_);
    if (child_ > 0) return {409, "A calibration is under way: finish or cancel it first.\n"};
  }
  if (thread_.joinable()) thread_.join();
  std::error_code error;
  std::vector<fs::path> kept = kept_in(options_.folder);
  for (; kept.size() >= kMostKept; kept.erase(kept.begin())) fs::remove_all(kept.front(), error);
  const std::string name = time_name(std::chrono::system_clock::now());
  const fs::path folder = fs::path(options_.folder) / name;
  fs::create_directories(options_.folder, error);
  if (!fs::create_directory(folder, error))
    return {409, fmt::format("{} can't be made: {}\n", folder.string(),
                             error ? error.message() : std::string("try again in a second"))};
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return {500, fmt::format("No pipe: {}\n", std::strerror(errno))};
  FileDescriptor told(ends[0]);
  const FileDescriptor tells(ends[1]);
  // What it says to people is in its lines as well.
  const Result<pid_t> child = start_program(
      {options_.program, "calibrate", of_head ? "pan-tilt" : "camera", "--tap", "--config", options_.config_path,
       "--out", (folder / (of_head ? kHeadFile : kCalibration)).string(), "--progress", "json"},
      tells.get(), -1);
  if (!child) {
    fs::remove_all(folder, error);
    return {500, fmt::format("{} can't be started: {}\n", options_.program, std::strerror(child.error().os_errno))};
  }
  const std::lock_guard lock(mutex_);
  child_ = *child;
  of_head_ = of_head;
  phase_ = Phase::kRunning;
  name_ = name;
  news_.clear(), why_.clear();
  asked_at_ = mono_now();
  ++number_;
  thread_ = std::thread([this, end = std::move(told)]() mutable { listen(std::move(end)); });
  return {200, json()};
}

DeskReply CalibrationDesk::signal_child(int number, Phase phase) {
  const std::lock_guard lock(mutex_);
  // One that is cancelled, or was given up, is about to end and nothing more.
  if (child_ <= 0 || phase_ != Phase::kRunning) return {409, "No calibration is under way.\n"};
  ::kill(child_, number);
  phase_ = phase;
  return {200, json()};
}

DeskReply CalibrationDesk::use(std::string_view name) {
  std::error_code none;
  const bool of_head = fs::exists(file_of(fmt::format("{}/{}", name, kHeadFile)), none);
  const std::string file = file_of(fmt::format("{}/{}", name, of_head ? kHeadFile : kCalibration));
  if (file.empty()) return {400, "There is no such calibration.\n"};
  try {
    return request_.begin(of_head ? "head" : "calibration", read_text_file(file, kMostLargeBody_bytes),
                          options_.has_token);
  } catch (const StartupError& error) {
    return {409, std::string(error.what()) + "\n"};
  }
}

std::string CalibrationDesk::state_json() {
  const std::lock_guard lock(mutex_);
  asked_at_ = mono_now();
  return json();
}

/// With the mutex held.
std::string CalibrationDesk::json() const {
  constexpr std::array<const char*, 5> kPhases{"idle", "running", "done", "failed", "cancelled"};
  return fmt::format(
      R"({{"why_not":{},"use":{},"calibration":{},"config":{},"folder":{},"head":{{"why_not":{},"limits":{}}},"of":"{}","phase":"{}","number":{},"name":"{}","why":{},"news":{}}})",
      json_text(options_.why_not), json_text(request_.why_not(options_.has_token)), json_text(options_.calibration),
      json_text(options_.config_path), json_text(options_.folder), json_text(options_.no_head), options_.limits,
      of_head_ ? "pan-tilt" : "camera", kPhases[static_cast<std::size_t>(phase_)], number_, name_, json_text(why_),
      news_.empty() ? "null" : news_);
}

std::string CalibrationDesk::file_of(std::string_view path) const {
  const std::size_t slash = std::min(path.find('/'), path.size());
  const std::string_view name = path.substr(0, slash), file = path.substr(std::min(slash + 1, path.size()));
  if (!is_time_name(name) || (file != kCalibration && file != kPicture && file != kHeadFile)) return {};
  return fmt::format("{}/{}/{}", options_.folder, name, file);
}

/// Until the child's end; what it says is taken at once, so that it waits for nobody.
void CalibrationDesk::listen(FileDescriptor told) {
  std::string line;
  std::array<char, 4096> part{};
  for (;;) {
    pollfd wanted{told.get(), POLLIN, 0};
    const int ready = ::poll(&wanted, 1, static_cast<int>(std::chrono::milliseconds(kLook).count()));
    {
      const std::lock_guard lock(mutex_);
      if (phase_ == Phase::kRunning && mono_now() - asked_at_ > unheard_) {
        ::kill(child_, SIGKILL);
        phase_ = Phase::kFailed;
        why_ = "No page has asked for a minute, so it was ended. What it has seen is kept, in " + options_.folder +
               "/" + name_ + ".";
      }
    }
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    const ssize_t count = ::read(told.get(), part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    for (const char c : std::string_view(part.data(), static_cast<std::size_t>(count))) {
      if (c == '\n')
        hear(std::exchange(line, {}));
      else if (line.size() <= kMostLine_bytes)
        line += c;
    }
  }
  // Its number is its own until it is reaped, under the mutex: no signal goes astray.
  siginfo_t ended{};
  while (::waitid(P_PID, static_cast<id_t>(child_), &ended, WEXITED | WNOWAIT) < 0 && errno == EINTR) {
  }
  end();
}

void CalibrationDesk::hear(std::string line) {
  const bool is_whole = line.size() <= kMostLine_bytes && line.ends_with('}') && !state_of(line).empty();
  const std::lock_guard lock(mutex_);
  if (is_whole) news_ = std::move(line);
}

void CalibrationDesk::end() {
  const std::lock_guard lock(mutex_);
  int status = 0;
  ::waitpid(child_, &status, 0);
  child_ = -1;
  std::error_code error;
  if (phase_ == Phase::kCancelled) {
    news_.clear();
    fs::remove_all(fs::path(options_.folder) / name_, error);
  }
  if (phase_ != Phase::kRunning) return;
  phase_ = state_of(news_) == "done" && WIFEXITED(status) && WEXITSTATUS(status) == 0 ? Phase::kDone : Phase::kFailed;
  if (phase_ == Phase::kFailed && state_of(news_) != "failed")
    why_ = WIFSIGNALED(status)
               ? fmt::format("{} was ended by signal {}: too little memory?", options_.program, WTERMSIG(status))
               : fmt::format("{} ended with status {}: try it in a terminal", options_.program, WEXITSTATUS(status));
}

}  // namespace ninedot
