#pragma once
/// Frames from a recording, as from a camera: a folder (or .y4m file) whose pictures a thread of its own decodes ahead.
#include <array>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/recording/recording_index.h"
#include "drivers/recording/recording_reader.h"
#include "ports/frame_source.h"

namespace ninedot {

enum class RecordingPace {
  kEveryFrame,  ///< as fast as they are taken, each exactly once and in order: for replays
  kRealTime,    ///< like a camera: each at its time, the newest wins, the others are counted
};

struct RecordingOptions {
  RecordingPace pace = RecordingPace::kEveryFrame;
  double rate_hz = 0;  ///< frames follow each other at this rate; 0 = at their recorded times
  bool loop = false;   ///< starts again at the end; frame numbers and times go on growing
  PictureSize
      size{};  ///< what the calibration is for; other pictures fail with kFrameSize. 0 x 0 = the recording's own
  /// A looped recording whose luma fits into this is decoded once, by the constructor.
  std::size_t preload_bytes = std::size_t{64} << 20U;
};

/// FrameLease::exposed_at is, with kEveryFrame, the recorded time; with kRealTime the instant at which the frame's turn
/// came (the clock starts at the first call of `next`).
///
/// A picture that is missing, damaged or of another size takes its place in the sequence as an error; asking again
/// gives the next frame. Memory: everything of ours is allocated by the constructor; libpng and libturbojpeg allocate
/// in the decoding thread, never in the caller's. At most kBufferCount - 1 leases may be held at a time without
/// stopping the decoder. Threads: one caller of `next`; leases may be given back from any thread.
class RecordingSource final : public FrameSource, private FrameOwner {
 public:
  static constexpr std::size_t kBufferCount = 4;  ///< one with the caller, one ready, one being decoded, one to spare

  /// Throws StartupError(kWorkFailed), one line that names the file: see read_recording_index.
  RecordingSource(const std::string& path, const RecordingOptions& options);
  ~RecordingSource() override;
  RecordingSource(const RecordingSource&) = delete;
  RecordingSource& operator=(const RecordingSource&) = delete;

  Result<FrameLease> next(MonoTime deadline) noexcept override;

  PictureSize size() const noexcept { return size_; }
  /// Frames of one pass, unreadable ones included.
  std::size_t frame_count() const noexcept { return index_.frames.size(); }
  /// "FILE: what is wrong" with the frame that `next` failed on last; valid until the next call of `next`.
  const char* last_failure() const noexcept { return last_failure_.data(); }

 private:
  static constexpr std::uint32_t kNoBuffer = 0xFFFFFFFFU;

  /// A frame in the queue: a picture or the reason why there is none.
  struct ReadyFrame {
    const RecordedFrame* frame = nullptr;
    const std::uint8_t* pixels = nullptr;  ///< null: `error` says why
    std::uint32_t buffer = kNoBuffer;      ///< to be given back; kNoBuffer: pixels are preloaded, or none
    Error error{Errc::kFrameUnreadable};
    std::uint64_t number = 0;
    MonoTime exposed_at{};
    std::uint32_t dropped_before = 0;
  };

  void give_back(std::uint32_t buffer) noexcept override;
  void preload();
  void run() noexcept;
  bool produce(std::size_t i, std::uint64_t pass) noexcept;
  std::optional<std::uint32_t> take_buffer() noexcept;
  void fill(ReadyFrame& ready, std::size_t i) noexcept;
  template <typename Condition>
  bool wait_for_turn(std::unique_lock<std::mutex>& lock, std::chrono::nanoseconds since_start,
                     Condition is_enough) noexcept;
  bool has_buffer() const noexcept { return free_count_ > 0 || !preloaded_.empty(); }
  void drop_oldest_ready() noexcept;
  void set_times();
  std::chrono::nanoseconds time_of(std::size_t i, std::uint64_t pass) const noexcept;

  RecordingOptions options_;
  RecordingIndex index_;
  PictureSize size_;
  RecordingReader reader_;
  std::vector<std::chrono::nanoseconds> times_;  ///< of each frame
  std::chrono::nanoseconds pass_duration_{};
  std::unique_ptr<std::uint8_t[]> store_;       ///< the buffers, or the preloaded pictures, one after the other
  std::vector<Result<PictureSize>> preloaded_;  ///< empty = not preloaded
  std::array<char, 512> last_failure_{};

  std::mutex mutex_;  ///< for all below
  std::condition_variable changed_;
  std::array<ReadyFrame, kBufferCount> ready_{};
  std::size_t ready_begin_ = 0, ready_count_ = 0;
  std::array<std::uint32_t, kBufferCount> free_{};
  std::size_t free_count_ = 0;
  std::uint32_t dropped_ = 0;  ///< since the last frame that became ready
  std::optional<MonoTime> started_at_;
  bool stop_ = false, finished_ = false;
  std::thread decoder_;  ///< last: it uses all of the above
};

}  // namespace ninedot
