#include "drivers/tap/tap_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/startup_error.h"
#include "drivers/tap/picture_layout.h"

namespace ninedot {
namespace {

constexpr int kAttempts = 3;

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", path, what));
}

std::string advice_of(int error) {
  if (error == ENOENT) return "no tap: is ninedotd running, and `enabled = true` in its [tap]?";
  if (error == EACCES) return "not permitted: join the group of this file, see docs/tap.md";
  return std::strerror(error);
}

/// All places lie within the file, as laid out by a service of this version.
bool is_sound_header(const TapHeader& header, std::uint64_t file_bytes) noexcept {
  const auto fits = [&](std::uint64_t offset, std::uint64_t slot_bytes, std::uint64_t least_bytes) {
    return offset <= file_bytes && slot_bytes >= least_bytes && slot_bytes <= (file_bytes - offset) / kTapSlots;
  };
  return header.segment_bytes == file_bytes && header.slot_count == kTapSlots &&
         header.pixels_offset >= sizeof(TapSlot) + sizeof(TapFrame) && header.pixels_offset <= file_bytes &&
         header.pixels_capacity <= file_bytes &&
         fits(header.frame_slots_offset, header.frame_slot_bytes, header.pixels_offset + header.pixels_capacity) &&
         fits(header.service_slots_offset, header.service_slot_bytes, sizeof(TapSlot) + sizeof(TapService));
}

/// Reads a word that the writer changes. The pages are read-only, and a load writes nothing.
std::uint64_t load(const std::uint64_t& word, std::memory_order order) noexcept {
  return std::atomic_ref<std::uint64_t>(const_cast<std::uint64_t&>(word)).load(order);
}

/// Copies slot after slot until one was whole. \param before  publications that are too old \param copy_slot  copies
/// what it wants of a slot; false: it can't be
template <typename CopySlot>
bool copy_whole(const std::uint64_t& newest, const std::byte* slots, std::size_t slot_bytes, std::uint64_t before,
                std::uint64_t& seen, CopySlot copy_slot) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const std::uint64_t publication = load(newest, std::memory_order_acquire);
    if (publication <= before || publication == seen) return false;
    const std::byte* const slot = slots + (publication - 1) % kTapSlots * slot_bytes;
    const std::uint64_t& sequence = reinterpret_cast<const TapSlot*>(slot)->sequence;
    if (load(sequence, std::memory_order_acquire) != 2 * publication) continue;
    const bool can_be = copy_slot(slot);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (load(sequence, std::memory_order_relaxed) != 2 * publication || !can_be) continue;
    seen = publication;
    return true;
  }
  return false;
}

}  // namespace

ImageView TapCopy::luma() const noexcept { return luma_of(frame.picture, pixels.data()); }
ChromaView TapCopy::chroma() const noexcept { return chroma_of(frame.picture, pixels.data()); }

TapReader::TapReader(const std::string& path) : file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (!file_) refuse(path, advice_of(errno));
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) refuse(path, std::strerror(errno));
  const auto file_bytes = static_cast<std::uint64_t>(status.st_size);
  if (file_bytes < sizeof(TapHeader)) refuse(path, "this is no tap of ninedotd");
  bytes_ = SharedBytes(file_.get(), file_bytes, false);
  if (!bytes_) refuse(path, std::strerror(errno));
  std::memcpy(&header_, bytes_.at(0), sizeof header_);
  if (header_.magic != kTapMagic || header_.byte_order != kTapByteOrder) refuse(path, "this is no tap of ninedotd");
  if (header_.version != kTapVersion)
    refuse(path, fmt::format("the service's tap is of version {}, this program reads version {}: install both of one "
                             "version, and restart ninedotd",
                             header_.version, kTapVersion));
  if (!is_sound_header(header_, file_bytes)) refuse(path, "the tap is damaged: restart ninedotd");
  if (!is_alive()) refuse(path, "the service behind this tap has ended: start ninedotd");
}

bool TapReader::is_alive() const noexcept { return is_tap_locked(file_.get(), kTapWriterLock_bytes, TapLock::kShared); }

void TapReader::announce(TapDemand demand) noexcept {
  for (const auto& [kind, byte] :
       {std::pair{TapDemand::kSome, kTapSomeLock_bytes}, {TapDemand::kEvery, kTapEveryLock_bytes}}) {
    if (kind == demand)
      static_cast<void>(take_tap_lock(file_.get(), byte, TapLock::kShared));
    else
      release_tap_lock(file_.get(), byte);
  }
  const auto* live = reinterpret_cast<const TapHeader*>(bytes_.at(0));
  frames_before_ = load(live->newest_frame, std::memory_order_acquire);
  services_before_ = load(live->newest_service, std::memory_order_acquire);
}

bool TapReader::has_newer(const TapCopy& copy) const noexcept {
  const auto* live = reinterpret_cast<const TapHeader*>(bytes_.at(0));
  const std::uint64_t newest = load(live->newest_frame, std::memory_order_acquire);
  return newest > frames_before_ && newest != copy.publication;
}

bool TapReader::copy_newest(TapCopy& copy) const {
  const auto* live = reinterpret_cast<const TapHeader*>(bytes_.at(0));
  return copy_whole(live->newest_frame, bytes_.at(header_.frame_slots_offset), header_.frame_slot_bytes, frames_before_,
                    copy.publication, [&](const std::byte* slot) {
                      std::memcpy(&copy.frame, slot + sizeof(TapSlot), sizeof copy.frame);
                      if (!is_sound(copy.frame.picture, header_.pixels_capacity)) return false;
                      copy.pixels.resize(copy.frame.picture.pixel_bytes);
                      if (!copy.pixels.empty())
                        std::memcpy(copy.pixels.data(), slot + header_.pixels_offset, copy.pixels.size());
                      return true;
                    });
}

bool TapReader::copy_newest(std::uint64_t& seen, TapService& service) const noexcept {
  const auto* live = reinterpret_cast<const TapHeader*>(bytes_.at(0));
  return copy_whole(live->newest_service, bytes_.at(header_.service_slots_offset), header_.service_slot_bytes,
                    services_before_, seen, [&](const std::byte* slot) {
                      std::memcpy(&service, slot + sizeof(TapSlot), sizeof service);
                      service.register_count = std::min<std::uint32_t>(service.register_count, kTapRegisterCount);
                      service.client_count = std::min<std::uint32_t>(service.client_count, kTapClientCount);
                      return true;
                    });
}

}  // namespace ninedot
