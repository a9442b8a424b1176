#pragma once
/// One place between a thread that fills buffers and one that wants the newest of them, without a lock.
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "base/contract.h"

namespace ninedot {

/// What the taker did not see since the buffer that it took before.
struct Unseen {
  std::uint32_t skipped = 0;  ///< good ones that a newer one replaced, or that never got a buffer
  std::uint32_t flagged = 0;  ///< damaged ones
};

/// Holds the number of at most one buffer. Both sides return at once, however long the other is kept from running.
/// Memory: inside. Threads: see each method.
class NewestWins {
 public:
  static constexpr std::uint32_t kCapacity = 32;       ///< buffers are numbered below it; VIDEO_MAX_FRAME of V4L2
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;  ///< no buffer: the index of none
  struct Taken {
    std::uint32_t buffer = kNone;
    Unseen unseen;
  };

  /// \param unseen  lost since the buffer put before, beside those that nobody took
  /// \return  index of the buffer that nobody took in time, to be used again; kNone: there was none
  /// Threads: one, the one that fills buffers.
  std::uint32_t put(std::uint32_t buffer, Unseen unseen) noexcept {
    EXPECTS(buffer < kCapacity);
    std::uint32_t older = newest_.load(std::memory_order_acquire);
    for (;;) {  // at most twice: the taker can take it away once, and nobody else puts
      unseen_[buffer] = unseen;
      if (older != kNone) {
        unseen_[buffer].skipped += unseen_[older].skipped + 1;
        unseen_[buffer].flagged += unseen_[older].flagged;
      }
      if (newest_.compare_exchange_strong(older, buffer, std::memory_order_acq_rel)) return older;
    }
  }
  /// The newest buffer, the caller's from now on; none: nothing new. Threads: one, the one that wants pictures.
  std::optional<Taken> take() noexcept {
    const std::uint32_t buffer = newest_.exchange(kNone, std::memory_order_acq_rel);
    if (buffer == kNone) return std::nullopt;
    return Taken{buffer, unseen_[buffer]};
  }
  /// Takes back what nobody took yet. Threads: the one that puts.
  std::optional<Taken> reclaim() noexcept { return take(); }

 private:
  std::atomic<std::uint32_t> newest_{kNone};
  std::array<Unseen, kCapacity> unseen_{};  // written by the one that puts, before it puts
};

}  // namespace ninedot
