// Three slots by turns, each with a sequence lock of its own (H. Boehm, "Can seqlocks get along with programming
// language memory models?", MSPC 2012, section 4). The payload is copied as plain bytes: writer and readers are
// different processes, and a reader throws away what it copied when the sequence says that it was torn.
#include "drivers/tap/tap_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>

#include "base/startup_error.h"
#include "drivers/tap/picture_layout.h"

namespace ninedot {
namespace {

constexpr std::size_t whole_pages(std::size_t bytes) noexcept {
  return (bytes + kTapPage_bytes - 1) / kTapPage_bytes * kTapPage_bytes;
}

/// Fills in where everything is.
TapHeader laid_out(TapHeader header) noexcept {
  const std::size_t pixel_count = std::size_t{header.width_px} * header.height_px;
  header.pixels_offset = whole_pages(sizeof(TapSlot) + sizeof(TapFrame));
  header.pixels_capacity = whole_pages(most_picture_bytes(pixel_count));
  header.frame_slots_offset = kTapPage_bytes;
  header.frame_slot_bytes = header.pixels_offset + header.pixels_capacity;
  header.service_slots_offset = header.frame_slots_offset + kTapSlots * header.frame_slot_bytes;
  header.service_slot_bytes = whole_pages(sizeof(TapSlot) + sizeof(TapService));
  header.segment_bytes = header.service_slots_offset + kTapSlots * header.service_slot_bytes;
  header.process_id = static_cast<std::uint32_t>(::getpid());
  return header;
}

[[noreturn]] void refuse(const std::string& path, int error, const char* advice) {
  throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}: {}", path, std::strerror(error), advice));
}

/// What stands at a path is replaced only if a service left it there: a tap, or one that it did not finish, which
/// begins with zeros. All else is somebody's; to open a pipe would wait for whoever writes it.
void expect_no_others(const std::string& path) {
  struct stat there {};
  if (::lstat(path.c_str(), &there) != 0) return;
  std::array<char, kTapMagic.size()> begins{};
  if (S_ISREG(there.st_mode)) {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    if (!file) refuse(path, errno, "[tap] can't tell whose this is; give it another path");
    const bool is_there = ::pread(file.get(), begins.data(), begins.size(), 0) == ssize_t{begins.size()};
    if (there.st_size == 0 || (is_there && (begins == kTapMagic || begins == decltype(begins){}))) return;
  }
  refuse(path, EEXIST, "this is no tap of ninedotd; give [tap] another path");
}

FileDescriptor make_file(const std::string& path, std::size_t size_bytes) {
  expect_no_others(path);
  ::unlink(path.c_str());
  FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR));
  if (!file) refuse(path, errno, "[tap] needs a folder in memory that the service may write, see docs/tap.md");
  // Memory that is promised but not there would end the service at the first touch.
  if (const int error = ::posix_fallocate(file.get(), 0, static_cast<off_t>(size_bytes)); error != 0) {
    ::unlink(path.c_str());
    refuse(path, error, "[tap] finds no room for the pictures there");
  }
  return file;
}

/// One slot while it is written: odd from construction on, even again at the end.
class SlotWriting {
 public:
  SlotWriting(std::byte* slot, std::uint64_t publication) noexcept
      : sequence_(reinterpret_cast<TapSlot*>(slot)->sequence), publication_(publication) {
    sequence_.store(2 * publication - 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
  }
  ~SlotWriting() { sequence_.store(2 * publication_, std::memory_order_release); }
  SlotWriting(const SlotWriting&) = delete;
  SlotWriting& operator=(const SlotWriting&) = delete;

 private:
  std::atomic_ref<std::uint64_t> sequence_;
  const std::uint64_t publication_;
};
static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free, "a lock would be this process's alone");

void tell(std::uint64_t& newest, std::uint64_t publication) noexcept {
  std::atomic_ref<std::uint64_t>(newest).store(publication, std::memory_order_release);
}

}  // namespace

TapWriter::TapWriter(const std::string& path, TapHeader header) : path_(path), places_(laid_out(header)) {
  expect_no_others(path);
  if (const FileDescriptor other(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
      other && is_tap_locked(other.get(), kTapWriterLock_bytes, TapLock::kShared))
    refuse(path, EBUSY, "another ninedotd serves this tap; give one of them another [tap] path");
  const std::string temporary = path + ".tmp";
  file_ = make_file(temporary, places_.segment_bytes);
  bytes_ = SharedBytes(file_.get(), places_.segment_bytes, true);
  if (!bytes_) refuse(temporary, errno, "[tap] can't map it");
  std::memset(bytes_.at(0), 0, bytes_.size());
  // Where it is refused the service's own lock_memory says so.
  static_cast<void>(::mlock(bytes_.at(0), bytes_.size()));
  std::memcpy(bytes_.at(0), &places_, sizeof places_);
  if (!take_tap_lock(file_.get(), kTapWriterLock_bytes, TapLock::kExclusive) ||
      ::fchmod(file_.get(), S_IRUSR | S_IWUSR | S_IRGRP) != 0 || ::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(temporary.c_str());
    refuse(path, error, "[tap] can't be set up there");
  }
}

TapWriter::~TapWriter() {
  struct stat ours {};
  struct stat there {};
  if (::fstat(file_.get(), &ours) == 0 && ::stat(path_.c_str(), &there) == 0 && ours.st_ino == there.st_ino)
    ::unlink(path_.c_str());
}

void TapWriter::look_for_readers() noexcept {
  const auto is_locked = [this](std::int64_t byte) { return is_tap_locked(file_.get(), byte, TapLock::kExclusive); };
  const TapDemand demand = is_locked(kTapEveryLock_bytes)  ? TapDemand::kEvery
                           : is_locked(kTapSomeLock_bytes) ? TapDemand::kSome
                                                           : TapDemand::kNothing;
  demand_.store(demand, std::memory_order_relaxed);
}

void TapWriter::publish(TapFrame& frame, const ImageView& luma, const ChromaView& chroma) noexcept {
  const std::uint64_t publication = ++frames_;
  std::byte* const slot =
      bytes_.at(places_.frame_slots_offset + (publication - 1) % kTapSlots * places_.frame_slot_bytes);
  const PictureLayout layout = picture_layout(luma, chroma, places_.pixels_capacity);
  frame.picture = layout.picture;
  {
    const SlotWriting writing(slot, publication);
    std::memcpy(slot + sizeof(TapSlot), &frame, sizeof frame);
    copy_picture(layout, slot + places_.pixels_offset);
  }
  tell(reinterpret_cast<TapHeader*>(bytes_.at(0))->newest_frame, publication);
}

void TapWriter::publish(const TapService& service) noexcept {
  const std::uint64_t publication = ++services_;
  std::byte* const slot =
      bytes_.at(places_.service_slots_offset + (publication - 1) % kTapSlots * places_.service_slot_bytes);
  {
    const SlotWriting writing(slot, publication);
    std::memcpy(slot + sizeof(TapSlot), &service, sizeof service);
  }
  tell(reinterpret_cast<TapHeader*>(bytes_.at(0))->newest_service, publication);
}

}  // namespace ninedot
