// The disk is read once, at the start; from then on the list is what this process did.
#include "programs/web/recording_shelf.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "base/startup_error.h"
#include "drivers/posix/whole_file.h"
#include "proto/frames_csv.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

// Of one that is being taken away: gone from the list, and from the disk at the latest when the program starts again.
constexpr std::string_view kDoomed = ".doomed-";
constexpr std::size_t kMostWords = 200;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::uint64_t bytes_below(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator place(folder, error), end; !error && place != end; place.increment(error))
    if (place->is_regular_file(error)) bytes += place->file_size(error);
  return bytes;
}

/// Takes away what no row tells of: `ninedot replay` would ask for it.
void remove_unlisted(const fs::path& folder, const std::set<std::uint64_t>& listed) {
  std::error_code error;
  std::vector<fs::path> unlisted;
  for (const fs::directory_entry& file : fs::directory_iterator(folder, error)) {
    const std::string name = file.path().filename().string();
    std::uint64_t number = 0;
    const auto [end, wrong] = std::from_chars(name.data(), name.data() + name.size(), number);
    const bool is_whole = wrong == std::errc() && end == name.data() + name.find('.') && !name.ends_with(".tmp");
    if (!is_whole || !listed.contains(number)) unlisted.push_back(file.path());
  }
  for (const fs::path& file : unlisted) fs::remove(file, error);
}

/// frames.csv without the part of a row that a power cut may leave at its end.
std::vector<FramesCsvRow> whole_rows(const fs::path& csv) {
  std::string text = text_of(csv);
  const std::size_t whole = text.rfind('\n') + 1;  // npos + 1: nothing
  if (whole != text.size()) {
    text.resize(whole);
    std::error_code error;
    fs::resize_file(csv, whole, error);
  }
  auto rows = parse_frames_csv(text);
  return rows ? std::move(*rows) : std::vector<FramesCsvRow>();
}

void mend(const fs::path& folder, const std::vector<FramesCsvRow>& rows) {
  std::set<std::uint64_t> listed;
  for (const FramesCsvRow& row : rows) listed.insert(row.frame);
  remove_unlisted(folder / "frames", listed);
  remove_unlisted(folder / "reports", listed);
  constexpr std::string_view kCutOff = "cut off: ninedot-web or the machine went down while it was made";
  static_cast<void>(write_whole_file((folder / "ended.txt").string(),
                                     {reinterpret_cast<const std::uint8_t*>(kCutOff.data()), kCutOff.size()}));
}

/// Nothing where nothing was recorded: then it is no longer there.
std::optional<ShelfEntry> entry_of(const fs::path& folder) {
  const std::vector<FramesCsvRow> rows = whole_rows(folder / "frames.csv");
  std::error_code error;
  if (!fs::exists(folder / "ended.txt", error)) {
    if (rows.empty()) {
      fs::remove_all(folder, error);
      return std::nullopt;
    }
    mend(folder, rows);
  }
  ShelfEntry entry;
  entry.name = folder.filename().string();
  entry.ended = text_of(folder / "ended.txt").substr(0, kMostWords);
  entry.bytes = bytes_below(folder);
  entry.frames = rows.size();
  if (rows.empty()) return entry;
  entry.missed = rows.back().frame + 1 - rows.size();
  entry.duration = std::chrono::nanoseconds(rows.back().timestamp_ns - rows.front().timestamp_ns);
  return entry;
}

}  // namespace

RecordingShelf::RecordingShelf(std::string folder) : folder_(std::move(folder)) {
  const auto refuse = [&](const std::string& what) {
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: no recordings: {}", folder_, what));
  };
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) refuse(fmt::format("the folder can't be made: {}", error.message()));
  lock_ = FileDescriptor(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!lock_ || ::access(folder_.c_str(), W_OK | X_OK) != 0)
    refuse(fmt::format("{}: give the folder to the user of ninedot-web", std::strerror(errno)));
  // Or what the other one records right now would be taken for what a crash left.
  if (::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) refuse("another ninedot-web uses this folder: give each its own");
  std::vector<fs::path> folders;
  for (const fs::directory_entry& place : fs::directory_iterator(folder_, error)) folders.push_back(place.path());
  for (const fs::path& place : folders) {
    const std::string name = place.filename().string();
    if (name.starts_with(kDoomed)) fs::remove_all(place, error);
    if (!is_recording_name(name)) continue;
    if (auto entry = entry_of(place)) add(std::move(*entry));
  }
  std::ranges::sort(entries_, {}, &ShelfEntry::name);
}

std::uint64_t RecordingShelf::bytes() const noexcept {
  std::uint64_t bytes = 0;
  for (const ShelfEntry& entry : entries_) bytes += entry.bytes;
  return bytes;
}

std::string RecordingShelf::free_name(RecordingCause cause) const {
  // Names sort by age, but not after a clock that was put back by more than this: then any will do.
  constexpr int kMostSeconds = 60;
  const auto now = std::chrono::system_clock::now();
  const auto is_older = [&](const ShelfEntry& entry, const std::string& name) {
    return cause_of(entry.name) != cause || entry.name < name;
  };
  std::string free;
  // A machine without a clock begins in the same minute each time: there is no end to the names that it may have used.
  for (int seconds = 0; free.empty() || seconds < kMostSeconds; ++seconds) {
    std::string name = recording_name(now + std::chrono::seconds(seconds), cause);
    std::error_code error;
    if (fs::exists(path_of(name), error)) continue;
    if (std::ranges::all_of(entries_, [&](const ShelfEntry& entry) { return is_older(entry, name); })) return name;
    if (free.empty()) free = std::move(name);
  }
  return free;
}

void RecordingShelf::add(ShelfEntry entry) { entries_.push_back(std::move(entry)); }

bool RecordingShelf::remove(std::string_view name) {
  const auto entry =
      std::find_if(entries_.begin(), entries_.end(), [&](const ShelfEntry& e) { return e.name == name; });
  if (entry == entries_.end()) return false;
  // Before it leaves the list, whose own text `name` may be.
  const std::string path = path_of(name), doomed = fmt::format("{}/{}{}", folder_, kDoomed, name);
  entries_.erase(entry);
  std::error_code error;
  fs::rename(path, doomed, error);
  fs::remove_all(doomed, error);
  return true;
}

bool RecordingShelf::remove_oldest_loss() {
  const auto loss = std::find_if(entries_.begin(), entries_.end(),
                                 [](const ShelfEntry& e) { return cause_of(e.name) == RecordingCause::kLoss; });
  return loss != entries_.end() && remove(std::string(loss->name));
}

std::size_t RecordingShelf::losses() const noexcept {
  return static_cast<std::size_t>(std::count_if(
      entries_.begin(), entries_.end(), [](const ShelfEntry& e) { return cause_of(e.name) == RecordingCause::kLoss; }));
}

}  // namespace ninedot
