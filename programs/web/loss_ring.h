#pragma once
/// The last seconds in memory, for whoever asks afterwards what was seen when the landmark was lost.
///
/// Pictures are kept as they come, every pixel exact: a copy costs 0.03 ms, where PNG costs 3.3 ms of a PC's processor
/// for each of 35 frames a second, for ever, and JPEG would no longer be what the detector saw. What does not fit is
/// thinned evenly: what happened over those seconds says more than each frame of the last one.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/tap/tap_reader.h"

namespace ninedot {

struct LossRules {
  std::chrono::nanoseconds before{};                        ///< kept from before the loss
  std::chrono::nanoseconds after{std::chrono::seconds{1}};  ///< and from after it
  /// A landmark that is not valid for so long is lost: tracking bridges less by itself.
  std::chrono::nanoseconds lost_after{std::chrono::milliseconds{500}};
  /// From one loss to the next that is kept: one that comes and goes must not fill the disk.
  std::chrono::nanoseconds rest{std::chrono::seconds{30}};
  std::size_t most_bytes = std::size_t{48} << 20U;  ///< of pixels
};

/// Memory: pixels of rules.most_bytes at most, made with the first picture, and 4 kB for each frame beside them.
/// Threads: one.
class LossRing {
 public:
  enum class Phase : std::uint8_t {
    kBlind,     ///< no landmark yet that could be lost
    kWatching,  ///< a landmark is there
    kLost,      ///< and no longer: the time after it is still to come
    kReady,     ///< to be saved; no frame is taken until `release`
  };

  explicit LossRing(LossRules rules) : rules_(rules) {}

  /// The next frame; its pixels are swapped for others. \param rate_hz  of the service
  void take(TapCopy& copy, double rate_hz);
  /// No frame came for a while: what was lost is saved without the time after it.
  void expire() noexcept;
  /// Another service, another camera: all is forgotten.
  void reset();

  Phase phase() const noexcept { return phase_; }
  /// Frames that are kept, the oldest first. [1]
  std::size_t size() const noexcept { return count_; }
  const TapCopy& at(std::size_t i) const noexcept { return slots_[(first_ + i) % slots_.size()]; }
  /// It is saved: the ring begins anew.
  void release() noexcept;

  std::uint64_t skipped() const noexcept { return skipped_; }                  ///< losses in the rest after another one
  std::chrono::nanoseconds spacing() const noexcept { return spacing_; }       ///< from frame to frame; 0: every one
  std::size_t bytes() const noexcept { return slots_.size() * frame_bytes_; }  ///< of pixels

 private:
  void plan(std::size_t frame_bytes, double rate_hz);
  void keep(TapCopy& copy);
  void judge(const TapFrame& frame);

  const LossRules rules_;
  std::vector<TapCopy> slots_;
  std::size_t first_ = 0, count_ = 0, frame_bytes_ = 0;
  std::chrono::nanoseconds spacing_{};
  Phase phase_ = Phase::kBlind;
  std::int64_t kept_at_ns_ = 0, valid_at_ns_ = 0;  // exposures
  std::int64_t rests_until_ns_ = 0;
  std::uint64_t skipped_ = 0;
};

}  // namespace ninedot
