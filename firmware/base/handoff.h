#pragma once
/// The newest value, from one thread to one other, wait-free on both sides: three slots, exchanged.
///
/// For what a thread of lower priority hands to a real-time one, where Mailbox would let the reader spin for as long as
/// the writer is not scheduled (see there: who may spin on whom). The writer owns one slot, the reader another; the
/// third lies between them and changes hands by one atomic exchange.
#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "base/mailbox.h"

namespace ninedot {

/// Memory: three values inside, no heap. Threads: see each method.
template <typename T, typename Pause = NoPause>
class Handoff {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit Handoff(const T& initial = T{}) noexcept : slots_{initial, initial, initial} {}
  Handoff(const Handoff&) = delete;
  Handoff& operator=(const Handoff&) = delete;

  /// Newest wins: what was not taken is lost. Wait-free. Threads: one, the writer.
  void put(const T& value) noexcept {
    slots_[writers_] = value;
    Pause::in_the_middle();
    writers_ = between_.exchange(writers_ | kFresh, std::memory_order_acq_rel) & kSlot;
  }

  /// The newest value; valid until the next call. Wait-free. Threads: one, the reader.
  const T& take() noexcept {
    if ((between_.load(std::memory_order_relaxed) & kFresh) != 0)
      readers_ = between_.exchange(readers_, std::memory_order_acq_rel) & kSlot;
    return slots_[readers_];
  }

 private:
  static constexpr std::uint32_t kSlot = 3, kFresh = 4;
  std::array<T, 3> slots_;
  std::uint32_t writers_ = 0, readers_ = 1;
  std::atomic<std::uint32_t> between_{2};  // a slot's number; kFresh: put and not yet taken
};

}  // namespace ninedot
