#pragma once
/// The wizards of `ninedot calibrate camera --tap` and `calibrate pan-tilt --tap` for the page: that program as a
/// child, at most one, and what it says.
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "base/mono_time.h"
#include "config/config.h"
#include "drivers/posix/file_descriptor.h"
#include "programs/web/apply_request.h"

namespace ninedot {

struct CalibrationDeskOptions {
  std::string why_not;      ///< for people: why nothing is calibrated from here; empty: it may be
  std::string program;      ///< `ninedot`
  std::string config_path;  ///< the service's
  std::string calibration;  ///< that it names; empty: none
  std::string folder;       ///< in which calibrations lie, each in a folder of its own
  bool has_token = false;   ///< of the page
  std::string no_head;      ///< as why_not, of the head alone
  std::string limits;       ///< of the head, for the page: {"pan":{"min":-45,"max":45},"tilt":...} [deg]
};

/// \param program  as above \param has_token  without one nothing is begun
CalibrationDeskOptions calibration_desk_options(const Config& config, const std::string& config_path,
                                                const std::string& program, bool has_token);

/// A child ends with this object, when a page says so, and when no page has asked for the state for kUnheard.
/// Memory: bounded: the child's newest line, and the one that it is saying. Threads: any; a start waits for the disk.
class CalibrationDesk {
 public:
  static constexpr std::size_t kMostLine_bytes = std::size_t{64} * 1024;
  static constexpr std::size_t kMostKept = 3;  ///< calibrations, with their views; the oldest go when one begins

  /// \param request  must outlive this \param unheard  a closed lid must not leave it running
  CalibrationDesk(CalibrationDeskOptions options, ApplyRequest& request,
                  std::chrono::nanoseconds unheard = std::chrono::minutes(1));
  ~CalibrationDesk();
  CalibrationDesk(const CalibrationDesk&) = delete;
  CalibrationDesk& operator=(const CalibrationDesk&) = delete;

  /// \param text  "start camera", "start pan-tilt", "finish": go on with what there is by now, "cancel", or "use
  /// NAME": that one is to take the place of the service's; not a character more
  /// \return  its status also: 400 not understood, 409 not now, 500 it could not be begun
  DeskReply reply_to(std::string_view text);
  /// What there is, for a page that is shown. \see docs/calibrating.md for the lines of the child in it
  std::string state_json();
  /// \param path  what follows /api/calibrate/ : NAME/camera.yaml, NAME/camera.svg or NAME/head.toml, to
  /// the last character
  /// \return  where it lies; empty: it is none of these
  std::string file_of(std::string_view path) const;

 private:
  enum class Phase : std::uint8_t { kIdle, kRunning, kDone, kFailed, kCancelled };

  DeskReply start(bool of_head);
  DeskReply signal_child(int number, Phase phase);
  DeskReply use(std::string_view name);
  std::string json() const;
  void listen(FileDescriptor told);
  void hear(std::string line);
  void end();

  const CalibrationDeskOptions options_;
  ApplyRequest& request_;
  const std::chrono::nanoseconds unheard_;
  std::mutex one_at_a_time_;  // of beginning
  std::thread thread_;
  mutable std::mutex mutex_;  // of what follows
  pid_t child_ = -1;          // -1: none
  Phase phase_ = Phase::kIdle;
  std::uint32_t number_ = 0;
  bool of_head_ = false;
  MonoTime asked_at_{};
  std::string name_;  // of the newest calibration
  std::string news_;  // its newest line
  std::string why_;   // it failed, unless its own line says so
};

}  // namespace ninedot
