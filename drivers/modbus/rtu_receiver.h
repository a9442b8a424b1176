#pragma once
/// Requests for one unit, out of the bytes of a serial line that others use as well.
///
/// MODBUS over Serial Line Specification V1.02, sections 2.5.1 (framing, 3.5 characters of silence) and 6.2.2 (CRC).
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace ninedot {

/// Of the bytes in the order of the line; its low byte is sent first.
std::uint16_t modbus_crc(std::span<const std::uint8_t> bytes) noexcept;

inline constexpr std::size_t kMaxRtuFrame = 256;

struct RtuRequest {
  std::span<const std::uint8_t> pdu;    ///< valid until the next call of the receiver
  std::span<const std::uint8_t> frame;  ///< the same with unit and check sum
  bool broadcast = false;               ///< carried out, never answered
};

/// Finds frames by their check sums, not by silence alone: a late thread sees several frames at once, and USB adapters
/// tear one frame into pieces. Memory: inside. Threads: one.
class RtuReceiver {
 public:
  explicit RtuReceiver(std::uint8_t unit) noexcept : unit_(unit) {}

  /// Bytes as they come, any number; when they are too many, the oldest are lost (counted as broken).
  void receive(std::span<const std::uint8_t> bytes) noexcept;

  /// The line has been silent for 3.5 characters: the request that ends here, if it is for us. Requests with anything
  /// behind them are too old to be answered: the line belongs to somebody else by now.
  std::optional<RtuRequest> end_of_frame() noexcept;

  /// The rest of a torn frame did not come: forget it, count it.
  void give_up() noexcept;

  bool has_fragment() const noexcept { return size_ > 0; }
  std::uint64_t broken_frames() const noexcept { return broken_frames_; }
  std::uint64_t foreign_frames() const noexcept { return foreign_frames_; }

 private:
  std::size_t valid_frame_at(std::size_t start, bool behind_noise) const noexcept;

  std::uint8_t unit_;
  std::array<std::uint8_t, 2 * kMaxRtuFrame> bytes_{};
  std::size_t size_ = 0;
  std::array<std::uint8_t, kMaxRtuFrame> request_{};
  std::uint64_t broken_frames_ = 0, foreign_frames_ = 0;
};

}  // namespace ninedot
