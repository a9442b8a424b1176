#pragma once
/// One long piece of work of `ninedot` for the page, a calibration or a map: that program as a child, at most one, and
/// what it says.
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/mono_time.h"
#include "drivers/posix/file_descriptor.h"
#include "programs/web/apply_request.h"

namespace ninedot {

enum class JobGroup : std::uint8_t { kCalibration, kMap };

struct JobOrder {
  JobGroup group = JobGroup::kCalibration;
  std::string_view of;  ///< what is made, for the page: "camera", "pan-tilt", "map"; a literal
  std::string folder;   ///< in which what jobs of this group make lies, each in a folder of its own
  /// Arguments of the program. \param folder  of this one
  std::function<std::vector<std::string>(const std::filesystem::path& folder)> words;
};

/// A child ends with this object, when a page says so, and when no page has asked for the state for kUnheard.
/// Memory: bounded: the child's newest line, and the one that it is saying. Threads: any; a start waits for the disk.
class ChildJob {
 public:
  static constexpr std::size_t kMostLine_bytes = std::size_t{256} * 1024;  ///< a map of a thousand landmarks
  static constexpr std::size_t kMostKept = 3;  ///< that were made, of each group; the oldest go when one begins

  /// \param program  `ninedot` \param unheard  a closed lid must not leave it running
  explicit ChildJob(std::string program, std::chrono::nanoseconds unheard = std::chrono::minutes(1))
      : program_(std::move(program)), unheard_(unheard) {}
  ~ChildJob();
  ChildJob(const ChildJob&) = delete;
  ChildJob& operator=(const ChildJob&) = delete;

  /// \return  200 and no text; 409 not now, 500 it could not be begun, with a line for people
  DeskReply start(const JobOrder& order);
  /// One that is under way goes on with what there is by now. \return  as of `start`: 409, there is none of this group
  DeskReply finish(JobGroup group);
  /// It ends, and keeps nothing.
  DeskReply cancel(JobGroup group);

  /// How the newest one fares, as fields of a JSON object: of, phase, number, name, why, news.
  /// \param asking  whose page asks for it: one of that group goes on
  std::string state_fields(JobGroup asking);

 private:
  enum class Phase : std::uint8_t { kIdle, kRunning, kDone, kFailed, kCancelled };

  DeskReply signal_child(JobGroup group, int number, Phase phase);
  void listen(FileDescriptor told);
  void hear(std::string line);
  void end();
  void note_end(int status);

  const std::string program_;
  const std::chrono::nanoseconds unheard_;
  std::mutex one_at_a_time_;  // of beginning
  std::thread thread_;
  std::mutex mutex_;  // of what follows
  pid_t child_ = -1;  // -1: none
  Phase phase_ = Phase::kIdle;
  std::uint32_t number_ = 0;
  JobGroup group_ = JobGroup::kCalibration;
  std::string_view of_ = "camera";
  MonoTime asked_at_{};
  std::string folder_, name_;  // of the newest one
  std::string news_;           // its newest line
  std::string why_;            // it failed, unless its own line says so
};

/// \param path  NAME/FILE, to the last character, as a request has it \param files  which FILEs there are
/// \return  where that lies below `folder`; empty: it is none of these
std::string file_of_job(const std::string& folder, std::string_view path,
                        std::initializer_list<std::string_view> files);

}  // namespace ninedot
