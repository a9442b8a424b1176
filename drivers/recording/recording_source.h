#pragma once
/// Frames from a recording, as from a camera: a folder (or .y4m file) whose pictures a thread of its own decodes ahead.
#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/posix/doorbell.h"
#include "drivers/posix/newest_wins.h"
#include "drivers/recording/recording_index.h"
#include "drivers/recording/recording_reader.h"
#include "ports/frame_source.h"

namespace ninedot {

enum class RecordingPace {
  kEveryFrame,  ///< as fast as they are taken, each exactly once and in order: for replays
  kRealTime,    ///< like a camera: each at its time, the newest wins, the others are counted
  kAsTaken,     ///< as kEveryFrame, and as from a camera: exposed at the instant at which it is taken
};

struct RecordingOptions {
  RecordingPace pace = RecordingPace::kEveryFrame;
  double rate_hz = 0;  ///< frames per second, whatever their recorded times; 0 = at their recorded times
  bool loop = false;   ///< starts again at the end; frame numbers and times go on growing
  PictureSize
      size{};  ///< what the calibration is for; other pictures fail with kFrameSize. 0 x 0 = the recording's own
  /// A looped recording whose pictures, luma and colour, fit into this is decoded once, by the constructor. 64 MiB:
  /// six seconds of grey pictures of 640 x 480 at 35 Hz.
  std::size_t preload_bytes = std::size_t{64} << 20U;
};

/// Frame::exposed_at() is, with kEveryFrame, the recorded time; with kRealTime the instant at which the frame's turn
/// came (the clock starts at the first call of `next`), with kAsTaken that of `next`. How long the exposure was, gain,
/// focus and zoom are not recorded.
///
/// A picture that is missing, damaged or of another size takes its place in the sequence as an error; asking again
/// gives the next frame. Memory: everything of ours is allocated by the constructor; libpng and libturbojpeg allocate
/// in the decoding thread, never in the caller's. Preloaded pictures with kAsTaken need no such thread. At most
/// kBufferCount - 1 leases may be held at a time without stopping the decoder. Threads: see each method; leases may be
/// given back from any thread. Neither that nor `next` waits for a lock: the decoding thread may be kept from running
/// anywhere.
class RecordingSource final : public FrameSource, private FrameOwner {
 public:
  static constexpr std::size_t kBufferCount = 4;  ///< one with the caller, one ready, one being decoded, one to spare

  /// Throws StartupError(kWorkFailed), one line that names the file: see read_recording_index.
  RecordingSource(const std::string& path, const RecordingOptions& options);
  ~RecordingSource() override;
  RecordingSource(const RecordingSource&) = delete;
  RecordingSource& operator=(const RecordingSource&) = delete;

  /// Threads: one caller.
  Result<FrameLease> next(MonoTime deadline) noexcept override;

  /// Threads: any.
  PictureSize size() const noexcept { return size_; }
  /// Frames of one pass, unreadable ones included. Threads: any.
  std::size_t frame_count() const noexcept { return index_.frames.size(); }
  /// Threads: any.
  bool tells_zoom() const { return index_.tells_zoom(); }
  /// "FILE: what is wrong" with the frame that `next` failed on last; valid until the next call of `next`.
  /// Threads: the caller of `next`.
  const char* last_failure() const noexcept { return last_failure_.data(); }

 private:
  /// A picture, or the reason why there is none.
  struct Picture {
    std::unique_ptr<std::uint8_t[]> bytes;  ///< luma, then as much of chroma as there may be
    Result<ChromaView> chroma;              ///< into `bytes`
  };
  /// A frame on its way from the decoding thread to `next`, and the picture that it has lent until it is given back.
  struct Buffer {
    const RecordedFrame* frame = nullptr;
    const Picture* picture = nullptr;
    std::uint64_t number = 0;
    MonoTime exposed_at{};
    Picture own;  ///< no bytes where the pictures are preloaded
  };
  static constexpr std::int64_t kNotStarted_ns = -1;

  void give_back(std::uint32_t buffer) noexcept override;
  Result<FrameLease> lend(const NewestWins::Taken& taken) noexcept;
  Result<FrameLease> lend_preloaded() noexcept;
  std::optional<NewestWins::Taken> take_ready() noexcept;
  bool preload();
  Result<ChromaView> decode(std::size_t i, std::uint8_t* bytes) noexcept;
  void run() noexcept;
  bool produce(std::size_t i, std::uint64_t pass) noexcept;
  void label(Buffer& buffer, std::size_t i, std::uint64_t pass) const noexcept;
  std::uint32_t take_free() noexcept;
  void put_ready(std::uint32_t buffer) noexcept;
  template <typename Condition>
  bool wait_until(MonoTime until, Condition is_enough) noexcept;
  template <typename Condition>
  bool wait_for_turn(std::chrono::nanoseconds since_start, Condition is_enough) noexcept;
  bool is_real_time() const noexcept { return options_.pace == RecordingPace::kRealTime; }
  bool needs_no_thread() const noexcept { return options_.pace == RecordingPace::kAsTaken && !preloaded_.empty(); }
  bool has_free() const noexcept { return free_.load(std::memory_order_acquire) != 0; }
  std::optional<MonoTime> started_at() const noexcept;
  void set_times();
  std::chrono::nanoseconds time_of(std::size_t i, std::uint64_t pass) const noexcept;

  RecordingOptions options_;
  RecordingIndex index_;
  PictureSize size_;
  RecordingReader reader_;
  std::vector<std::chrono::nanoseconds> times_;  ///< of each frame
  std::chrono::nanoseconds pass_duration_{};
  std::vector<Picture> preloaded_;  ///< empty = not preloaded
  std::uint64_t lent_ = 0;          ///< with kAsTaken, of preloaded pictures: frames so far
  std::array<char, 512> last_failure_{};

  // Handed over by the atomics below: a buffer belongs to the decoding thread while it is free and being filled, then
  // to the caller of `next` until it is given back.
  std::array<Buffer, kBufferCount> buffers_;
  std::atomic<std::uint32_t> free_{(1U << kBufferCount) - 1};  ///< a bit for each buffer
  NewestWins newest_;                                          ///< with kRealTime
  std::array<std::uint32_t, kBufferCount> queue_{};            ///< otherwise; as long as there are buffers
  std::atomic<std::uint32_t> queued_{0};                       ///< how many were ever put into it
  std::uint32_t unqueued_ = 0;                                 ///< how many were taken out; the caller of `next`
  std::uint32_t dropped_ = 0;                                  ///< since the newest ready frame; the decoding thread
  std::atomic<std::int64_t> started_at_ns_{kNotStarted_ns};
  std::atomic<bool> stop_{false}, finished_{false};
  Doorbell ready_;       ///< for `next`
  Doorbell changed_;     ///< for the decoding thread: started, given back, to be stopped
  std::thread decoder_;  ///< last: it uses all of the above
};

}  // namespace ninedot
