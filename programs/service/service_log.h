#pragma once
/// The few lines that the service writes while it runs: what changed, not what is.
#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "base/result.h"
#include "report/report.h"

namespace ninedot {

class LiveDisplay;

/// Hears each line that is written.
class LogListener {
 public:
  virtual ~LogListener() = default;
  virtual void on_line(const std::string& line, MonoTime now) noexcept = 0;
};

/// Threads: one caller.
class ServiceLog {
 public:
  /// \param display  makes room on the terminal before each line; may be null.
  explicit ServiceLog(LiveDisplay* display = nullptr) : display_(display) {}

  /// One line to standard error: "ninedotd: LINE", of log_text(): what a file quotes may be as long as the file.
  void write(const std::string& text);

  /// \param listener  hears the lines that follow; must outlive this log, or be taken away (null)
  void tell(LogListener* listener) noexcept { listener_ = listener; }

  /// Says at the start why there is no camera yet; note() does not say so again.
  void note_camera_absent(const std::string& refusal);

  /// Says when the landmark comes and goes and when the camera fails and recovers: a change that has lasted for
  /// kSettle (and the very first one at once), so that a landmark at the edge of sight does not fill the disk. Of a
  /// camera that stays away also another error that has lasted for kOtherCause: what hinders it now may be mended.
  void note(const Report& report, const Error& last_error, MonoTime now);

  /// Says once what moving landmarks have shown of the camera's shutter.
  void note_row_time(const RowTime& rows);

  /// Says which landmarks do not hang where the map says, and which contradict each other: somebody has to go and
  /// measure them. Each once, when it has lasted for kSettle, and again where it was well for kWasWell: chance has one
  /// rejected now and then. \param report  a new one
  void note_misplaced(const Report& report, MonoTime now);

  /// Says when a device goes, what else keeps it away, and when it is back, likewise; of the first time only what is to
  /// be said.
  /// \param problem  why it is not in use; empty: it is \param description  about one in use; may be empty
  void note_device(const std::string& name, const std::string& problem, const std::string& description, MonoTime now);

  /// Says that something happened: the first time at once, then at most once a minute how often it did, so that a flood
  /// does not fill the disk.
  /// \param count  how often since the start; grows \param what  "frames that can't be read" \param last  about the
  /// newest one; may be empty
  void note_series(const std::string& what, std::uint64_t count, const std::string& last, MonoTime now);

 private:
  static constexpr std::chrono::milliseconds kSettle{500};
  /// Longer than the longest pause between two attempts: one that fails in turns in two ways is not told twice.
  static constexpr std::chrono::seconds kOtherCause{15};
  static constexpr std::chrono::minutes kSeriesPeriod{1};
  /// A sheet that was moved is out of view for most of a robot's round.
  static constexpr std::chrono::hours kWasWell{1};
  LiveDisplay* display_;
  LogListener* listener_ = nullptr;
  RowTimeSource said_row_time_ = RowTimeSource::kTold;
  Reason said_ = Reason::kStarting;
  Reason seen_ = Reason::kStarting;
  MonoTime seen_since_{};

  /// Why something stays away: what was said of it, and what is so by now.
  class Cause {
   public:
    /// What is said, or was by somebody else.
    void say(const std::string& cause) { said_ = seen_ = cause; }
    /// \return  whether it is another one that has lasted; then it counts as said
    bool is_another(const std::string& cause, MonoTime now);

   private:
    std::string said_, seen_;
    MonoTime since_{};
  };
  Cause source_cause_;
  bool is_source_cause_known_ = false;

  struct Device {
    bool is_known = false, was_in_use = false;  // what was said
    bool is_in_use = false;
    MonoTime since{};
    Cause cause;
  };
  struct Series {
    std::uint64_t said = 0;
    MonoTime said_at{};
  };
  /// What is said once, when it has lasted.
  class Lasting {
   public:
    /// It is so now. \return  whether that is to be said
    bool is_news(MonoTime now);

   private:
    MonoTime since_{}, last_{};
    bool is_said_ = false;
  };
  std::map<std::uint16_t, Lasting> misplaced_;                // by landmark
  std::map<std::array<std::uint16_t, 2>, Lasting> disputed_;  // by pair
  std::map<std::string, Device> devices_;
  std::map<std::string, Series> series_;
};

}  // namespace ninedot
