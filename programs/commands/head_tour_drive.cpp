#include "programs/commands/head_tour_drive.h"

#include <algorithm>

#include "aim/head_kinematics.h"
#include "base/units.h"
#include "config/head_options.h"
#include "programs/commands/collect_head_frames.h"

namespace ninedot {
HeadTourOptions tour_options(const Config& config, const CameraModel& camera, int columns, int rows) {
  const AimOptions aim = aim_options(config.pan_tilt);
  const HeadKinematics view(camera, {});
  HeadTourOptions options;
  options.min = {aim.pan.min_rad, aim.tilt.min_rad};
  options.max = {aim.pan.max_rad, aim.tilt.max_rad};
  options.start = aim.neutral;
  options.home = config.pan_tilt.park_at_shutdown ? aim.park : aim.neutral;
  options.half_width_rad = view.half_width_rad();
  options.half_height_rad = view.half_height_rad();
  options.columns = columns, options.rows = rows;
  return options;
}

void OutputHead::go(const HeadAngles& goal) { head_.order({.follow = false, .set_point = goal, .number = ++number_}); }

TouredHead::State OutputHead::state(const Frame& frame) {
  const HeadSnapshot& head = head_.snapshots().take();
  return {head.track.at(frame.exposed_at()), head.failed, head.inhibited,
          head.order == number_ ? head.progress : OrderProgress::kNone};
}

HeadTourDrive::HeadTourDrive(const HeadTourOptions& options, TouredHead& head) : tour_(options), head_(head) {
  head_.go(tour_.goal());
}

void HeadTourDrive::take(const Frame& frame, const Fix& fix) {
  head_now_ = head_.state(frame);
  const bool was_held = is_held_;
  is_held_ = is_inhibited() || is_failing();
  if (is_held_) return;
  if (was_held) return head_.go(tour_.goal());  // what it was told before has failed
  frames_.push_back(head_frame_of(fix, frame.exposed_at(), told(), 0));
  const bool has_failed = head_now_.progress == OrderProgress::kFailed;  // its pulses end before, or it comes too late
  if (!has_failed && head_now_.progress != OrderProgress::kDone) return;
  if (tour_.part() == HeadTour::Part::kHome) {
    is_over_ = true;
    return;
  }
  if (has_failed) {
    tour_.skip();
    head_.go(tour_.goal());
  } else if (tour_.look(direction_in(frames_.back()))) {
    head_.go(tour_.goal());
  }
}

/// Of the landmark that was looked at before, as long as it is in sight: where its middle is.
std::optional<Eigen::Vector2d> HeadTourDrive::direction_in(const HeadFrame& frame) {
  if (frame.seen.empty()) return std::nullopt;
  const auto same = std::ranges::find(frame.seen, looked_at_, &LandmarkSighting::id);
  const LandmarkSighting& sighting = same != frame.seen.end() ? *same : frame.seen.front();
  looked_at_ = sighting.id;
  return sighting.T_camera_landmark.translation_m.hnormalized();
}

}  // namespace ninedot
