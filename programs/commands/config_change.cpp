#include "programs/commands/config_change.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>

#include "base/startup_error.h"
#include "drivers/posix/text_file.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_work(const std::string& path, const std::string& what) {
  throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", path, what));
}

template <typename T>
T need(Result<T> result, const std::string& path) {
  if (!result) fail_work(path, fmt::format("{}: {}", result.error().text, std::strerror(result.error().os_errno)));
  return std::move(*result);
}

std::string real_file(const std::string& path) {
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  if (error)
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("{}: there is no file to replace: {}", path, error.message()));
  if (!fs::is_regular_file(real, error))
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{}: is no file that could be replaced", path));
  return real.string();
}

}  // namespace

ApplyLock::ApplyLock(const std::string& config_path)
    : folder_(::open(fs::path(real_file(config_path)).parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (!folder_) fail_work(config_path, fmt::format("its folder can't be opened: {}", std::strerror(errno)));
  if (::flock(folder_.get(), LOCK_EX | LOCK_NB) != 0)
    fail_work(config_path, errno == EWOULDBLOCK ? "another apply is under way: wait for its end"
                                                : fmt::format("its folder can't be locked: {}", std::strerror(errno)));
}

ConfigChange::ConfigChange(const std::string& path, WriteFunction write_bytes)
    : path_(real_file(path)), write_bytes_(write_bytes) {
  text_ = read_text_file(path_, kMaxApplied_bytes);
  was_cut_short_ = fs::is_regular_file(last_good_path());
  last_good_ = was_cut_short_ ? read_text_file(last_good_path(), kMaxApplied_bytes) : text_;
}

FileReplacement ConfigChange::written_beside(const std::string& path, std::string_view text) const {
  FileReplacement file = need(FileReplacement::begin(path), path);
  need(file.keep_rights(path_), path);
  need(file.write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, write_bytes_), path);
  return file;
}

void ConfigChange::put(std::string_view text) {
  // Both are on the disk before either is in its place: a disk that is full is found out while nothing has changed.
  FileReplacement file = written_beside(path_, text);
  if (!was_cut_short_) need(written_beside(last_good_path(), text_).commit(Durability::kPowerCut), last_good_path());
  const Result<std::size_t> done = file.commit(Durability::kPowerCut);
  if (done) return;
  // Renamed or not, what FILE is to be again is known.
  need(move_whole_file(last_good_path(), path_), path_);
  need(done, path_);
}

void ConfigChange::confirm() { need(move_whole_file(last_good_path(), before_path()), before_path()); }
void ConfigChange::put_back() { need(move_whole_file(last_good_path(), path_), path_); }

}  // namespace ninedot
