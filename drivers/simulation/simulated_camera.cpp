// The servos are moved on when a frame needs to know where they were. All commands that could have had an effect until
// then have been given: frames arrive after their exposure.
#include "drivers/simulation/simulated_camera.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

// A frame is worked out so long before it arrives, if its exposure has ended: twice what a near sheet takes.
constexpr std::chrono::milliseconds kAhead{4};

std::chrono::nanoseconds from_s(double seconds) noexcept {
  return std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

/// From the middle of the middle row's exposure to the end of the last row's; at most half a period.
std::chrono::nanoseconds half_of(const SimulationOptions& options) noexcept {
  const double whole_s =
      options.renderer.exposure_s + options.renderer.row_time_s * std::max(0, options.camera.height_px - 1);
  return from_s(std::min(whole_s, 1 / options.rate_hz) / 2);
}

}  // namespace

SimulatedCamera::SimulatedCamera(const SimulationOptions& options, std::shared_ptr<HeadLine> line,
                                 SimulationClock& clock)
    : options_(options),
      line_(std::move(line)),
      clock_(clock),
      renderer_(options.camera, options.sheets, options.renderer),
      half_(half_of(options)),
      delay_(std::max(options.camera_delay, half_)),
      pan_(options.pan, options.start.pan_rad, clock.now()),
      tilt_(options.tilt, options.start.tilt_rad, clock.now()) {
  EXPECTS(!options.robot.empty() && options.rate_hz > 0 && options.duration_s > 0);
}

Result<FrameLease> SimulatedCamera::next(MonoTime deadline) noexcept {
  EXPECTS(!is_lent_);
  if (!has_started_) started_at_ = clock_.now();
  has_started_ = true;
  const std::uint64_t newest = newest_arrived();
  const auto lost = static_cast<std::uint32_t>(newest - std::min(frame_, newest));
  frame_ = std::max(frame_, newest);
  const MonoTime at = exposed_at(frame_);
  if (!options_.loop && at - started_at_ >= from_s(options_.duration_s))
    return fail(Errc::kEndOfStream, "the simulation is over");
  if (at + delay_ > deadline) {
    clock_.sleep_until(deadline);
    return fail(Errc::kNoFrame, "no frame in time");
  }
  clock_.sleep_until(at + std::max(half_, delay_ - kAhead));
  hear_commands();
  ExposureMotion motion;
  motion.half_s = half_;
  motion.T_world_camera[0] = camera_at(at - half_, nullptr);
  motion.T_world_camera[1] = camera_at(at, &truth_);
  motion.T_world_camera[2] = camera_at(at + half_, nullptr);
  note_landmark(motion.T_world_camera[1]);
  const bool hidden = is_hidden(truth_.t_s);
  if (hidden) truth_.visible = false;
  renderer_.render(motion, hidden, frame_);
  clock_.sleep_until(at + delay_);

  is_lent_ = true;
  FrameLease lease(this, 0);
  lease.frame.number = frame_++;
  lease.frame.luma = renderer_.luma();
  lease.frame.chroma = renderer_.chroma();
  lease.frame.set_exposure(at, from_s(options_.renderer.exposure_s));
  lease.frame.row_time = from_s(options_.renderer.row_time_s);
  lease.frame.head = truth_.head;
  lease.frame.head_at = at;
  lease.dropped_before = lost;
  return lease;
}

void SimulatedCamera::give_back(std::uint32_t /*buffer*/) noexcept { is_lent_ = false; }

MonoTime SimulatedCamera::exposed_at(std::uint64_t frame) const noexcept {
  return started_at_ + from_s(static_cast<double>(frame) / options_.rate_hz);
}

/// The newest frame that has arrived by now, or the first one.
std::uint64_t SimulatedCamera::newest_arrived() const noexcept {
  const std::chrono::duration<double> since_s = clock_.now() - started_at_ - delay_;
  auto frame = static_cast<std::uint64_t>(std::max(0.0, since_s.count() * options_.rate_hz));
  while (frame > 0 && exposed_at(frame) + delay_ > clock_.now()) --frame;
  return frame;
}

double SimulatedCamera::path_time_s(MonoTime at) const noexcept {
  const double t_s = std::chrono::duration<double>(at - started_at_).count();
  return options_.loop && t_s > 0 ? std::fmod(t_s, options_.duration_s) : t_s;
}

void SimulatedCamera::hear_commands() noexcept {
  const HeadCommands& commands = line_->newest.take();
  const std::uint64_t kept = commands.list.size();
  if (commands.count > commands_heard_ + kept) commands_heard_ = commands.count - kept;
  for (; commands_heard_ < commands.count; ++commands_heard_) {
    const HeadCommands::Command& command = commands.list[commands_heard_ % kept];
    const HeadAngles angles = options_.true_angles ? options_.true_angles(command.angles) : command.angles;
    pan_.command(command.at, angles.pan_rad);
    tilt_.command(command.at, angles.tilt_rad);
  }
}

/// Where the camera is. Moves the servos on.
Eigen::Isometry3d SimulatedCamera::camera_at(MonoTime at, SimulationTruth* truth) noexcept {
  pan_.advance(at);
  tilt_.advance(at);
  const double t_s = path_time_s(at);
  const WayPoint body = place_on(options_.robot, t_s);
  const HeadAngles head{pan_.angle_rad(), tilt_.angle_rad()};
  const Eigen::Isometry3d T_world_camera = world_from_camera(body, options_.mount, head);
  if (truth != nullptr) *truth = {t_s, body, head, T_world_camera.translation()};
  return T_world_camera;
}

/// What the truth says of the main landmark.
void SimulatedCamera::note_landmark(const Eigen::Isometry3d& T_world_camera) noexcept {
  const HungSheet* main = nullptr;
  double nearest_m = 0;
  for (const HungSheet& sheet : options_.sheets) {
    const Eigen::Vector3d seen_m = sheet.T_world_sheet.inverse() * T_world_camera.translation();
    if (seen_m.y() <= 0 || (main != nullptr && seen_m.norm() >= nearest_m)) continue;
    main = &sheet;
    nearest_m = seen_m.norm();
  }
  if (main == nullptr) return;
  const Eigen::Vector3d p = T_world_camera.inverse() * main->T_world_sheet.translation();
  truth_.centre_error_rad = std::atan2(p.head<2>().norm(), p.z());
  if (p.z() <= 0) return;
  const Eigen::Vector2d point = p.head<2>() / p.z();
  const Eigen::Vector2d pixel = project(options_.camera, point);
  truth_.visible = point.norm() <= renderer_.farthest_ray() && pixel.x() >= 0 && pixel.y() >= 0 &&
                   pixel.x() <= options_.camera.width_px - 1 && pixel.y() <= options_.camera.height_px - 1;
}

bool SimulatedCamera::is_hidden(double t_s) const noexcept {
  return std::ranges::any_of(options_.hidden,
                             [&](const HiddenTime& hidden) { return t_s >= hidden.from_s && t_s < hidden.to_s; });
}

}  // namespace ninedot
