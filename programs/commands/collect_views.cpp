#include "programs/commands/collect_views.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/startup_error.h"
#include "drivers/recording/recording_source.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

}  // namespace

CalibrationPictures check_recordings(const std::vector<std::string>& recordings) {
  CalibrationPictures pictures{recordings, {}};
  for (const std::string& recording : recordings) {
    std::error_code ignored;
    if (std::filesystem::is_fifo(recording, ignored))
      refuse(fmt::format("{}: a pipe is no recording: give a file", recording));
    try {
      const PictureSize size = read_recording_index(recording).size;
      if (pictures.size.pixel_count() == 0) pictures.size = size;
      if (size == pictures.size) continue;
      refuse(fmt::format("{}: its pictures are {}x{}, those of {} are {}x{}: calibrate each size by itself", recording,
                         size.width_px, size.height_px, recordings.front(), pictures.size.width_px,
                         pictures.size.height_px));
    } catch (const StartupError& error) {
      refuse(error.what());
    }
  }
  return pictures;
}

CollectedViews collect_views(const CalibrationPictures& pictures, SheetFinder& finder, std::span<const PlaneDisc> discs,
                             const std::function<bool(const std::string& what)>& go_on) {
  CollectedViews collected{ViewCollection(pictures.size.width_px), 0};
  for (std::size_t i = 0; i < pictures.recordings.size(); ++i) {
    RecordingSource source(pictures.recordings[i], {});
    for (std::size_t count = 0;;) {
      if (!go_on(fmt::format("{}: picture {} of {}, {} views", pictures.recordings[i], count, source.frame_count(),
                             collected.views.views().size())))
        return collected;
      const Result<FrameLease> lease = source.next(mono_now() + 200ms);
      if (!lease && lease.error().code == Errc::kEndOfStream) break;
      if (!lease && lease.error().code == Errc::kNoFrame) continue;
      if (!lease && lease.error().code == Errc::kFrameSize)
        refuse(fmt::format("{}: calibrate each size by itself", source.last_failure()));
      if (!lease)
        throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: repair the recording", source.last_failure()));
      ++count, ++collected.pictures;
      std::vector<SeenDisc> seen = finder.find(lease->frame.luma);
      if (seen.empty()) continue;
      SheetView view = keep_view(lease->frame.luma, sensor_of(lease->frame), std::move(seen), discs);
      view.recording = i, view.frame = lease->frame.number;
      collected.views.add(std::move(view));
    }
  }
  return collected;
}

}  // namespace ninedot
