#include "programs/web/child_job.h"

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
#include <utility>

#include "base/json_text.h"
#include "drivers/posix/child_program.h"
#include "programs/web/recording_name.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kLook = 200ms;

/// The oldest first.
std::vector<fs::path> kept_in(const fs::path& folder) {
  std::vector<fs::path> kept;
  std::error_code error;
  for (fs::directory_iterator place(folder, error), end; !error && place != end; place.increment(error))
    if (is_time_name(place->path().filename().string())) kept.push_back(place->path());
  std::ranges::sort(kept);
  return kept;
}

/// Of the first second from now on that has none: who starts anew at once must not be told to wait.
fs::path new_folder(const fs::path& parent, std::error_code& error) {
  fs::create_directories(parent, error);
  for (auto begun = std::chrono::system_clock::now();; begun += 1s) {
    const fs::path folder = parent / time_name(begun);
    if (fs::create_directory(folder, error) || error) return folder;
  }
}

std::string_view state_of(std::string_view line) {
  constexpr std::string_view kStart = R"({"state":")";
  if (!line.starts_with(kStart)) return {};
  line.remove_prefix(kStart.size());
  return line.substr(0, line.find('"'));
}

/// For people. \return  "A calibration is under way"
const char* under_way(JobGroup group) {
  return group == JobGroup::kMap ? "A map is being built" : "A calibration is under way";
}

}  // namespace

ChildJob::~ChildJob() {
  {
    const std::lock_guard lock(mutex_);
    if (child_ > 0) ::kill(child_, SIGKILL);
  }
  if (thread_.joinable()) thread_.join();
}

DeskReply ChildJob::start(const JobOrder& order) {
  const std::lock_guard one(one_at_a_time_);
  {
    const std::lock_guard lock(mutex_);
    if (child_ > 0)
      return {409, fmt::format("{}: {} it first.\n", under_way(group_),
                               group_ == JobGroup::kMap ? "cancel" : "finish or cancel")};
  }
  if (thread_.joinable()) thread_.join();
  std::error_code error;
  std::vector<fs::path> kept = kept_in(order.folder);
  for (; kept.size() >= kMostKept; kept.erase(kept.begin())) fs::remove_all(kept.front(), error);
  const fs::path folder = new_folder(order.folder, error);
  if (error) return {409, fmt::format("{} can't be made: {}\n", folder.string(), error.message())};
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return {500, fmt::format("No pipe: {}\n", std::strerror(errno))};
  FileDescriptor told(ends[0]);
  const FileDescriptor tells(ends[1]);
  std::vector<std::string> words = order.words(folder);
  words.insert(words.begin(), program_);
  words.insert(words.end(), {"--progress", "json"});
  // What it says to people is in its lines as well.
  const Result<pid_t> child = start_program(words, tells.get(), -1);
  if (!child) {
    fs::remove_all(folder, error);
    return {500, fmt::format("{} can't be started: {}\n", program_, std::strerror(child.error().os_errno))};
  }
  const std::lock_guard lock(mutex_);
  child_ = *child;
  group_ = order.group, of_ = order.of;
  phase_ = Phase::kRunning;
  folder_ = order.folder, name_ = folder.filename().string();
  news_.clear(), why_.clear();
  asked_at_ = mono_now();
  ++number_;
  thread_ = std::thread([this, end = std::move(told)]() mutable { listen(std::move(end)); });
  return {200, {}};
}

DeskReply ChildJob::finish(JobGroup group) { return signal_child(group, SIGINT, Phase::kRunning); }
DeskReply ChildJob::cancel(JobGroup group) { return signal_child(group, SIGKILL, Phase::kCancelled); }

DeskReply ChildJob::signal_child(JobGroup group, int number, Phase phase) {
  const std::lock_guard lock(mutex_);
  // One that is cancelled, or was given up, is about to end and nothing more.
  if (child_ <= 0 || phase_ != Phase::kRunning || group_ != group)
    return {409, group == JobGroup::kMap ? "No map is being built.\n" : "No calibration is under way.\n"};
  ::kill(child_, number);
  phase_ = phase;
  return {200, {}};
}

std::string ChildJob::state_fields(JobGroup asking) {
  constexpr std::array<const char*, 5> kPhases{"idle", "running", "done", "failed", "cancelled"};
  const std::lock_guard lock(mutex_);
  if (asking == group_) asked_at_ = mono_now();
  return fmt::format(R"("of":"{}","phase":"{}","number":{},"name":"{}","why":{},"news":{})", of_,
                     kPhases[static_cast<std::size_t>(phase_)], number_, name_, json_text(why_),
                     news_.empty() ? "null" : news_);
}

/// Until the child's end; what it says is taken at once, so that it waits for nobody.
void ChildJob::listen(FileDescriptor told) {
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
        why_ = "No page has asked for a minute, so it was ended.";
        if (group_ == JobGroup::kCalibration)
          why_ += fmt::format(" What it has seen is kept, in {}/{}.", folder_, name_);
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

void ChildJob::hear(std::string line) {
  const bool is_whole = line.size() <= kMostLine_bytes && line.ends_with('}') && !state_of(line).empty();
  const std::lock_guard lock(mutex_);
  if (is_whole) news_ = std::move(line);
}

void ChildJob::end() {
  const std::lock_guard lock(mutex_);
  int status = 0;
  ::waitpid(child_, &status, 0);
  child_ = -1;
  if (phase_ == Phase::kCancelled) news_.clear();
  if (phase_ == Phase::kRunning) note_end(status);
  // Of a map that failed nothing is of use; of a camera that was watched the views are.
  const bool is_worthless = phase_ == Phase::kCancelled || (phase_ == Phase::kFailed && group_ == JobGroup::kMap);
  std::error_code error;
  if (is_worthless) fs::remove_all(fs::path(folder_) / name_, error);
}

/// It came to an end by itself.
void ChildJob::note_end(int status) {
  phase_ = state_of(news_) == "done" && WIFEXITED(status) && WEXITSTATUS(status) == 0 ? Phase::kDone : Phase::kFailed;
  if (phase_ == Phase::kFailed && state_of(news_) != "failed")
    why_ = WIFSIGNALED(status)
               ? fmt::format("{} was ended by signal {}: too little memory?", program_, WTERMSIG(status))
               : fmt::format("{} ended with status {}: try it in a terminal", program_, WEXITSTATUS(status));
}

std::string file_of_job(const std::string& folder, std::string_view path,
                        std::initializer_list<std::string_view> files) {
  const std::size_t slash = std::min(path.find('/'), path.size());
  const std::string_view name = path.substr(0, slash), file = path.substr(std::min(slash + 1, path.size()));
  if (!is_time_name(name) || std::ranges::find(files, file) == files.end()) return {};
  return fmt::format("{}/{}/{}", folder, name, file);
}

}  // namespace ninedot
