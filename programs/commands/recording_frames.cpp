#include "programs/commands/recording_frames.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <system_error>

#include "base/startup_error.h"
#include "drivers/posix/signals.h"
#include "drivers/recording/recording_source.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/recording_camera.h"
#include "programs/commands/progress.h"

namespace ninedot {

using namespace std::chrono_literals;

void check_recording(const std::string& recording) {
  try {
    static_cast<void>(read_recording_index(recording));
  } catch (const StartupError& error) {
    throw StartupError(ExitStatus::kWrongUsage, error.what());
  }
}

void refuse_repeated(const std::vector<std::string>& recordings) {
  std::error_code ignored;
  for (std::size_t i = 0; i < recordings.size(); ++i)
    for (std::size_t other = 0; other < i; ++other)
      if (std::filesystem::equivalent(recordings[i], recordings[other], ignored))
        throw StartupError(ExitStatus::kWrongUsage, fmt::format("{} is given twice: once is enough", recordings[i]));
}

RecordingView view_of_recording(const std::string& recording, const std::string& camera_file, const Config& config) {
  check_recording(recording);
  return {recording_camera(recording, camera_file, config), localiser_options(config).seeker.landmark};
}

SeenFrames look_at_frames(
    const std::string& recording, const Config& config, const RecordingView& view, bool tracking,
    const std::function<void(const Frame& frame, const Fix& fix, const LandmarkObservation* seen)>& use) {
  const TerminationSignals signals;  // before the source's thread
  RecordingSource source(recording, {});
  check_picture_size(source, view.camera, recording);
  LocaliserOptions options = localiser_options(config);
  options.tracking = tracking;
  options.learns_row_time = false;  // whoever calibrates looks through one shutter all the time
  const auto localiser = make_localiser(view.camera, options);
  Progress progress;
  SeenFrames seen;
  for (;;) {
    if (signals.wait(0ns) != 0) {
      seen.is_interrupted = true;
      return seen;
    }
    const Result<FrameLease> lease = source.next(mono_now() + 1s);
    if (!lease && lease.error().code == Errc::kEndOfStream) return seen;
    if (!lease && lease.error().code == Errc::kNoFrame) continue;
    if (!lease)
      throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: repair the recording", source.last_failure()));
    ++seen.frames;
    const Fix& fix = localiser->process(lease->frame);
    use(lease->frame, fix, localiser->last_observation());
    if (progress.is_due()) progress.show(fmt::format("picture {} of {}", seen.frames, source.frame_count()));
  }
}

void tell_interruption(const SeenFrames& seen) {
  if (seen.is_interrupted)
    fmt::print(stderr, "ninedot: interrupted after {} pictures: what follows is of those\n", seen.frames);
}

}  // namespace ninedot
