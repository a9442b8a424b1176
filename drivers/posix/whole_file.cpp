#include "drivers/posix/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <utility>

#include "base/mono_time.h"
#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

/// A fifo's writer may be started beside its reader.
constexpr std::chrono::seconds kWriterComes{1};

/// A name beside `path` that is nobody else's. \param make  makes the file of that name; false, and errno: it can't
/// \return  empty, and errno: it can't be made
template <typename Make>
std::string made_beside(const std::string& path, Make make) {
  constexpr int kMostTries = 1000;  // names that runs which were killed left behind
  static std::atomic<unsigned> counter{0};
  for (int i = 0; i < kMostTries; ++i) {
    std::string name = path + "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
    if (make(name)) return name;
    if (errno != EEXIST) break;
  }
  return {};
}

std::string folder_of(const std::string& path) {
  const std::size_t end = path.rfind('/');
  return end == std::string::npos ? "." : path.substr(0, end + 1);
}

/// The only name of a file that has none (open(2), O_TMPFILE).
std::string proc_name(const FileDescriptor& file) { return "/proc/self/fd/" + std::to_string(file.get()); }

/// In the folder of `path`: it goes with whoever writes it, however that ends. \return  none: the file system has no
/// such files, or there is no /proc to give them a name
FileDescriptor open_nameless(const std::string& path) {
  FileDescriptor file(::open(folder_of(path).c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0644));
  return file && ::access(proc_name(file).c_str(), F_OK) == 0 ? std::move(file) : FileDescriptor();
}

/// Where a link leads, so that it stays one.
std::string resolved(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || !S_ISLNK(status.st_mode)) return path;
  const std::unique_ptr<char, decltype(&std::free)> target(::realpath(path.c_str(), nullptr), &std::free);
  return target ? target.get() : path;
}

/// Without this the rename itself may be lost. \return  0 or an errno
int sync_folder_of(const std::string& path) noexcept {
  const FileDescriptor descriptor(::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some network file systems know no such thing (EINVAL); they have the file where we can do no more for it.
  if (!descriptor || ::fsync(descriptor.get()) == 0 || errno == EINVAL) return 0;
  return errno;
}

}  // namespace

ssize_t write_to_disk(int descriptor, const void* bytes, std::size_t count) noexcept {
  return ::write(descriptor, bytes, count);
}

Result<std::size_t> read_whole_file(const char* path, std::span<std::uint8_t> buffer) noexcept {
  // Opening a fifo waits for a writer, and nothing ends that where signals are kept for later. One without a writer
  // reads as an empty file, and one whose writer is still at work says so. Nothing else is opened in another way: a
  // file that somebody has a lease on would be refused.
  struct stat status {};
  const bool is_pipe = ::stat(path, &status) == 0 && S_ISFIFO(status.st_mode);
  const int descriptor = ::open(path, O_RDONLY | O_CLOEXEC | (is_pipe ? O_NONBLOCK : 0));
  if (descriptor < 0) return fail(Errc::kIo, "cannot be opened", errno);
  pollfd readable{descriptor, POLLIN, 0};
  bool has_writer = !is_pipe || poll_until(std::span(&readable, 1), mono_now() + kWriterComes) > 0;
  std::size_t size = 0;
  int error = 0;
  for (;;) {
    std::uint8_t beyond = 0;  // one byte more than fits tells a file that fits exactly from one that is too long
    const bool is_full = size == buffer.size();
    const ssize_t count =
        is_full ? ::read(descriptor, &beyond, 1) : ::read(descriptor, buffer.data() + size, buffer.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN && is_pipe) {
      has_writer = true;
      (void)poll_until(std::span(&readable, 1), MonoTime::max());
      continue;
    }
    if (count < 0) error = errno;
    if (count > 0 && is_full) error = EFBIG;
    if (count <= 0 || error != 0) break;
    size += static_cast<std::size_t>(count);
  }
  ::close(descriptor);
  if (error != 0) return fail(Errc::kIo, "cannot be read", error);
  if (!has_writer && size == 0) return fail(Errc::kIo, "is a pipe that nobody writes to");
  return size;
}

Result<std::size_t> write_all(int descriptor, std::span<const std::uint8_t> bytes, WriteFunction write_bytes) noexcept {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = write_bytes(descriptor, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return fail(Errc::kIo, "cannot be written", count < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(count);
  }
  return done;
}

Result<FileReplacement> FileReplacement::begin(const std::string& path) {
  FileReplacement file;
  file.path_ = resolved(path);
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return fail(Errc::kIo, "cannot be created", EISDIR);
  if (exists && !S_ISREG(status.st_mode)) {  // a device or a fifo can't be replaced, only written
    file.file_ = FileDescriptor(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  } else {
    file.file_ = open_nameless(file.path_);
    file.is_nameless_ = static_cast<bool>(file.file_);
    if (!file.is_nameless_)
      file.temporary_ = made_beside(file.path_, [&](const std::string& name) {
        file.file_ = FileDescriptor(::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
        return static_cast<bool>(file.file_);
      });
  }
  if (!file.file_) return fail(Errc::kIo, "cannot be created", errno);
  return file;
}

FileReplacement::~FileReplacement() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Result<std::size_t> FileReplacement::keep_rights(const std::string& model) noexcept {
  struct stat status {};
  if (::stat(model.c_str(), &status) != 0) return fail(Errc::kIo, "is not there to be replaced", errno);
  // The owner first: a change of it takes bits of the mode away.
  if (::fchown(file_.get(), status.st_uid, status.st_gid) != 0 || ::fchmod(file_.get(), status.st_mode & 07777U) != 0)
    return fail(Errc::kIo, "can't be given the owner and mode of the file that it replaces", errno);
  return 0;
}

Result<std::size_t> FileReplacement::write(std::span<const std::uint8_t> bytes, WriteFunction write_bytes) noexcept {
  return write_all(file_.get(), bytes, write_bytes);
}

Result<std::size_t> FileReplacement::settle(Durability durability) noexcept {
  if (is_settled_) return 0;
  const bool is_synced = durability == Durability::kPowerCut && (is_nameless_ || !temporary_.empty());
  if (is_synced && ::fsync(file_.get()) != 0) return fail(Errc::kIo, "cannot be written", errno);
  // Network file systems report a full disk as late as here; what has no name yet is on none of them.
  if (!is_nameless_ && ::close(file_.let_go()) != 0) return fail(Errc::kIo, "cannot be written", errno);
  is_settled_ = true;
  return 0;
}

Result<std::size_t> FileReplacement::commit(Durability durability) noexcept {
  NINEDOT_TRY([[maybe_unused]] const std::size_t nothing, settle(durability));
  // A link can't take another file's place, a rename can: so it gets a name beside it for a moment.
  if (is_nameless_) {
    temporary_ = made_beside(path_, [this](const std::string& name) {
      return ::linkat(AT_FDCWD, proc_name(file_).c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
    });
    if (temporary_.empty()) return fail(Errc::kIo, "cannot be given its name", errno);
  }
  if (temporary_.empty()) return 0;
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) return fail(Errc::kIo, "cannot be renamed", errno);
  temporary_.clear();
  if (const int error = durability == Durability::kPowerCut ? sync_folder_of(path_) : 0; error != 0)
    return fail(Errc::kIo, "is written, but a power cut may undo it", error);
  return 0;
}

Result<std::size_t> move_whole_file(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) return fail(Errc::kIo, "cannot be renamed", errno);
  if (const int error = sync_folder_of(to); error != 0)
    return fail(Errc::kIo, "is renamed, but a power cut may undo it", error);
  return 0;
}

Result<std::size_t> write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes,
                                     Durability durability, WriteFunction write_bytes) {
  NINEDOT_TRY(FileReplacement file, FileReplacement::begin(path));
  NINEDOT_TRY(const std::size_t written, file.write(bytes, write_bytes));
  NINEDOT_TRY([[maybe_unused]] const std::size_t nothing, file.commit(durability));
  return written;
}

}  // namespace ninedot
