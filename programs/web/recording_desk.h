#pragma once
/// What is done with each frame: recorded because somebody asked, kept in case the landmark is lost, or neither.
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/mono_time.h"
#include "programs/web/frame_queue.h"
#include "programs/web/loss_ring.h"
#include "programs/web/recording_shelf.h"
#include "programs/web/tap_recording.h"

namespace ninedot {

struct RecordingRules {
  std::uint64_t most_bytes = 0;      ///< of all recordings together
  std::chrono::nanoseconds longest;  ///< one that was asked for
  LossRules loss;                    ///< with `before` of 0 no loss is kept
  std::size_t most_losses = 0;       ///< recordings of them; the oldest go
};

/// What people are told.
struct RecordingState {
  std::vector<ShelfEntry> entries;    ///< the oldest first
  std::optional<ShelfEntry> running;  ///< what was asked for
  bool is_awaited = false;            ///< asked for, and no frame has come yet
  std::string note;                   ///< why the last one ended by itself, or what could not be done
  std::uint64_t bytes = 0, most_bytes = 0;
  std::chrono::nanoseconds longest{};
  bool keeps_losses = false, is_saving = false;  ///< is_saving: a loss is being written
  LossRing::Phase phase = LossRing::Phase::kBlind;
  std::chrono::nanoseconds before{}, spacing{};
  std::uint64_t skipped = 0;
  std::size_t ring_bytes = 0;
};

/// Memory: the ring's; beyond that what writing a frame takes. Threads: one; waits for the disk.
class RecordingDesk {
 public:
  /// Without a frame for so long a recording is over.
  static constexpr std::chrono::seconds kPatience{3};

  /// \param tell  takes a line for the log
  RecordingDesk(RecordingRules rules, RecordingShelf& shelf, std::function<void(const std::string&)> tell,
                WriteFunction write_bytes = write_to_disk);

  void start(MonoTime now);
  void stop(std::string_view why);
  void remove(std::string_view name);

  /// The next frame; its pixels may be swapped for others.
  void take(QueuedFrame& frame, MonoTime now);
  /// Between frames. \param trouble  why none come; empty: not known
  void wait(MonoTime now, std::string_view trouble);
  /// One frame of a loss that is being saved. \return  whether there is more to be done
  bool save_one();
  /// The program ends: nothing more is taken or saved.
  void close();

  bool wants_frames() const noexcept { return is_asked() || keeps_losses(); }
  RecordingState state() const;

 private:
  bool is_asked() const noexcept { return is_awaited_ || asked_.has_value(); }
  bool keeps_losses() const noexcept { return rules_.loss.before.count() > 0; }
  bool has_room(std::uint64_t bytes) const noexcept;
  void begin(const TapHeader& header);
  void record(const TapCopy& copy);
  void end_asked(const std::string& why);
  void begin_saving();
  void end_saving(std::string_view why);
  void note(const std::string& text);
  std::string full_text() const;

  const RecordingRules rules_;
  RecordingShelf& shelf_;
  const std::function<void(const std::string&)> tell_;
  const WriteFunction write_bytes_;
  std::shared_ptr<const TapHeader> header_;
  MonoTime heard_at_{};
  bool is_awaited_ = false;
  std::optional<TapRecording> asked_, loss_;
  std::uint64_t next_bytes_ = 0;  // what a frame took last
  LossRing ring_;
  std::size_t saved_ = 0;  // of the ring's frames
  std::string note_;
};

}  // namespace ninedot
