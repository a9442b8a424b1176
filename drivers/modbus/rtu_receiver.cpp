#include "drivers/modbus/rtu_receiver.h"

#include <algorithm>

#include "drivers/modbus/request.h"

namespace ninedot {
namespace {

constexpr std::size_t kCrcBytes = 2, kMinFrame = 4;

constexpr auto kCrcTable = [] {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < table.size(); ++i) {
    unsigned crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xA001U : crc >> 1U;
    table[i] = static_cast<std::uint16_t>(crc);
  }
  return table;
}();

bool has_valid_crc(std::span<const std::uint8_t> frame) noexcept {
  const std::uint16_t crc = modbus_crc(frame.first(frame.size() - kCrcBytes));
  return frame[frame.size() - 2] == (crc & 0xFFU) && frame[frame.size() - 1] == crc >> 8U;
}

bool is_bit_or_register_read(std::uint8_t function) noexcept { return function >= 1 && function <= 4; }
bool is_multiple_write(std::uint8_t function) noexcept { return function == 15 || function == 16; }

/// Lengths that a frame starting with these bytes can have as a request and as a reply; 0 where unknown.
std::array<std::size_t, 2> expected_lengths(std::span<const std::uint8_t> bytes) noexcept {
  const std::uint8_t function = bytes[1];
  if ((function & kExceptionFlag) != 0) return {0, 5};
  if (is_bit_or_register_read(function)) return {8, 5U + bytes[2]};
  if (function == 5 || function == 6) return {8, 8};
  if (is_multiple_write(function)) return {bytes.size() > 6 ? 9U + bytes[6] : 0U, 8};
  return {0, 0};
}

/// A reply on the line (another unit's, or our own, brought back by an adapter) must never be taken for a request.
bool is_reply(std::span<const std::uint8_t> frame) noexcept {
  const std::uint8_t function = frame[1];
  if ((function & kExceptionFlag) != 0) return true;
  if (is_bit_or_register_read(function)) return frame.size() != 8 && frame.size() == 5U + frame[2];
  return is_multiple_write(function) && frame.size() == 8;
}

}  // namespace

std::uint16_t modbus_crc(std::span<const std::uint8_t> bytes) noexcept {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) crc = crc >> 8U ^ kCrcTable[(crc ^ byte) & 0xFFU];
  return static_cast<std::uint16_t>(crc);
}

void RtuReceiver::receive(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() > bytes_.size()) bytes = bytes.last(bytes_.size());
  if (bytes.size() > bytes_.size() - size_) {
    const std::size_t lost = bytes.size() - (bytes_.size() - size_);
    std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(lost), bytes_.begin() + static_cast<std::ptrdiff_t>(size_),
              bytes_.begin());
    size_ -= lost;
    ++broken_frames_;
  }
  std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
}

std::size_t RtuReceiver::valid_frame_at(std::size_t start, bool behind_noise) const noexcept {
  const std::span<const std::uint8_t> rest(bytes_.data() + start, size_ - start);
  if (rest.size() < kMinFrame) return 0;
  for (const std::size_t length : expected_lengths(rest))
    if (length >= kMinFrame && length <= rest.size() && length <= kMaxRtuFrame && has_valid_crc(rest.first(length)))
      return length;
  // A function that we don't know, or a request of a wrong length: silence alone tells where it ends. Behind noise, one
  // place in 65536 would match by chance and swallow the true request.
  return !behind_noise && rest.size() <= kMaxRtuFrame && has_valid_crc(rest) ? rest.size() : 0;
}

std::optional<RtuRequest> RtuReceiver::end_of_frame() noexcept {
  std::optional<RtuRequest> request;
  std::size_t unresolved = 0;  // bytes before this one are dealt with
  for (std::size_t start = 0; start + kMinFrame <= size_;) {
    const std::size_t length = valid_frame_at(start, start != unresolved);
    if (length == 0) {
      ++start;
      continue;
    }
    if (start != unresolved) ++broken_frames_;
    const std::span<const std::uint8_t> frame(bytes_.data() + start, length);
    start += length;
    unresolved = start;
    const bool ours = frame[0] == unit_ || frame[0] == 0;
    if (!ours || is_reply(frame)) {
      ++foreign_frames_;
    } else if (start == size_) {
      std::copy(frame.begin(), frame.end(), request_.begin());
      const std::span<const std::uint8_t> kept(request_.data(), length);
      request = RtuRequest{kept.subspan(1, length - 1 - kCrcBytes), kept, frame[0] == 0};
    }
  }
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(unresolved),
            bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.begin());
  size_ -= unresolved;
  return request;
}

void RtuReceiver::give_up() noexcept {
  if (size_ > 0) ++broken_frames_;
  size_ = 0;
}

}  // namespace ninedot
