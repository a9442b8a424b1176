#include "programs/commands/collect_sightings.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "base/startup_error.h"
#include "drivers/recording/recording_source.h"
#include "mapping/row_interpolation.h"
#include "pipeline/sighting_uncertainty.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/recording_camera.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

bool is_of_use(const LandmarkFix& landmark) {
  return landmark.verdict == Reason::kNone || landmark.verdict == Reason::kAmbiguous ||
         landmark.verdict == Reason::kUncertain || landmark.verdict == Reason::kMoved;
}

/// One picture's, with how each landmark moved in it.
struct Look {
  RecordedSightings shown;
  std::vector<RowMotion> motions;  // as long as its list
};

/// What the pictures before and after say of how the landmarks moved goes into where they are, and how certain that is.
std::vector<RecordedSightings> with_rows_settled(std::vector<Look> looks, const CameraModel& camera) {
  std::vector<RowedSighting> all;
  for (Look& look : looks)
    for (std::size_t i = 0; i < look.motions.size(); ++i) {
      const RowMotion& motion = look.motions[i];
      all.push_back({&look.shown.list[i], look.shown.time, motion.sheet, motion.uncertainty.per_row_rad(true)});
    }
  interpolate_rows(all, camera);
  std::vector<RecordedSightings> frames;
  auto settled = all.begin();
  for (Look& look : looks) {
    for (const RowMotion& motion : look.motions) {
      widen(*settled->seen, {settled->per_row_rad, 0, 0, motion.uncertainty.middle_row_px}, camera, true);
      ++settled;
    }
    frames.push_back(std::move(look.shown));
  }
  return frames;
}

}  // namespace

std::vector<RecordedSightings> collect_sightings(
    const std::string& recording, std::size_t index, const Config& config, const CameraModel& camera,
    const std::function<void(std::size_t frame, std::size_t frames)>& progress) {
  RecordingSource source(recording, {});
  check_picture_size(source, camera, recording);
  LocaliserOptions options = localiser_options(config);
  // Places that are being looked for tell nothing of the shutter: a map that a wrong row time has bent confirms it.
  options.learns_row_time = false;
  if (!options.row_time) options.row_time = std::chrono::nanoseconds{0};
  options.seeker.regards_walls = true;
  options.search_every = 1;  // there is time, and a landmark that comes into view is worth more here than anywhere else
  const auto localiser = make_localiser(camera, options);
  std::vector<Look> looks;
  for (std::size_t count = 0;;) {
    const Result<FrameLease> lease = source.next(mono_now() + 1s);
    if (!lease && lease.error().code == Errc::kEndOfStream) return with_rows_settled(std::move(looks), camera);
    if (!lease && lease.error().code == Errc::kNoFrame) continue;
    if (!lease)
      throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: repair the recording", source.last_failure()));
    const Fix& fix = localiser->process(lease->frame);
    Look look{{index, lease->frame.number, lease->frame.exposed_at(), {}}, {}};
    for (const LandmarkFix& landmark : fix.landmarks) {
      if (!is_of_use(landmark)) continue;
      look.shown.list.push_back(landmark.sighting);
      look.motions.push_back(landmark.row_motion);
      const Eigen::Vector3d& t_m = landmark.sighting.T_camera_landmark.translation_m;
      look.shown.fastest_px_s =
          std::max(look.shown.fastest_px_s, camera.fx_px * landmark.row_motion.sheet.ray_velocity(t_m, t_m).norm());
    }
    if (!look.shown.list.empty()) looks.push_back(std::move(look));
    if (progress) progress(++count, source.frame_count());
  }
}

}  // namespace ninedot
