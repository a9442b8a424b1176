#pragma once
/// The page's recordings: one thread that takes frames from the tap, one that writes them, and what pages may ask.
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "config/config.h"
#include "programs/web/frame_queue.h"
#include "programs/web/recording_desk.h"
#include "programs/web/recording_shelf.h"

namespace ninedot {

struct RecorderOptions {
  std::string why_not;  ///< for people: why nothing is recorded; empty: something may be
  std::string tap_path, folder;
  bool may_ask = false;  ///< false: no page can start, stop or delete any, for there is no token
  RecordingRules rules;
};

/// \param has_token  without one no page may ask for any
RecorderOptions recorder_options(const Config& config, bool has_token);

struct RecorderReply {
  unsigned status = 200;  ///< HTTP: 400 not understood, 404 no such recording, 409 not now
  std::string json;       ///< always the whole state
};

/// While nobody asks for a recording and no losses are kept, both threads sleep and the tap is closed: nothing is
/// copied and nothing is made.
/// Memory: the queue's and the ring's, made when they are needed. Threads: any; no call waits for the disk.
class Recorder {
 public:
  /// Looks through the folder. Where it can't be used the page says why, and goes on without.
  explicit Recorder(RecorderOptions options);
  /// What is being recorded stays, up to its last frame.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// \param text  "start", "stop" or "delete NAME", and not a character more
  RecorderReply reply_to(std::string_view text);
  std::string state_json() const;
  /// Of a recording that has ended. \return  empty: there is none of this name, or it is not over
  std::string folder_of(std::string_view name) const;

 private:
  enum class Wish : std::uint8_t { kNone, kStart, kStop };
  static constexpr std::size_t kMostDeletions = 8;

  RecorderReply refused(unsigned status, const std::string& why) const;
  bool has(std::string_view name) const;
  std::string json_of(std::string_view problem) const;
  void take_frames();
  void write_frames();
  void carry_out_wishes();
  void publish();

  RecorderOptions options_;
  std::unique_ptr<RecordingShelf> shelf_;  // of the thread that writes; the desk likewise
  std::unique_ptr<RecordingDesk> desk_;
  FrameQueue queue_;

  mutable std::mutex mutex_;  // of what follows; never held while anybody waits for the disk
  std::condition_variable demand_;
  RecordingState state_;
  Wish wish_ = Wish::kNone;
  std::vector<std::string> doomed_;
  std::string trouble_;  // why no frame comes
  bool wants_frames_ = false, ending_ = false;

  std::thread taker_, writer_;  // none where nothing is recorded
};

}  // namespace ninedot
