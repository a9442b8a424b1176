#include "programs/commands/world_rows.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <string_view>

#include "base/units.h"
#include "outputs/told_angles.h"

namespace ninedot {
namespace {

/// Without "-0.000": equal poses give equal bytes.
std::string decimals(double value, int count) {
  std::string text = fmt::format("{:.{}f}", value, count);
  if (text.find_first_not_of("-0.") == std::string::npos && text.front() == '-') text.erase(0, 1);
  return text;
}

std::string joined(const Eigen::Vector3d& v, int count) {
  return fmt::format("{},{},{}", decimals(v.x(), count), decimals(v.y(), count), decimals(v.z(), count));
}

/// The body's where it was asked for. \param covariance  of T_world_camera [m^2, m rad, rad^2]
BodyPose shown_pose(const WorldFromCamera& T_world_camera, const BodyCovariance& covariance,
                    const std::optional<BodyGeometry>& body, const Frame& frame) {
  if (!body) return {{T_world_camera.rotation, T_world_camera.translation_m}, covariance};
  return body_in_world(T_world_camera, covariance, camera_on_body(*body, frame.head.value_or(HeadAngles{})));
}

std::string pose_columns(const BodyPose& pose) {
  const auto& [T, covariance] = pose;
  const Eigen::Quaterniond q = T.quaternion();
  const auto sigma_mm = [&covariance = pose.covariance](Eigen::Index axis) {
    return std::sqrt(covariance(axis, axis)) / kMetresPerMm;
  };
  return fmt::format("{},{},{},{:.6f},{:.6f},{:.6f},{:.6f}", joined(T.translation_m / kMetresPerMm, 6),
                     decimals(q.w(), 9), joined(q.vec(), 9), sigma_mm(0), sigma_mm(1), sigma_mm(2),
                     std::sqrt(covariance(3, 3) + covariance(4, 4) + covariance(5, 5)) / kRadPerDeg);
}

/// With the comma before them.
std::string angle_names(const std::optional<EulerConvention>& euler) {
  if (!euler) return {};
  constexpr std::array<std::array<std::string_view, 3>, 3> kNames{
      {{"yaw", "pitch", "roll"}, {"w", "p", "r"}, {"a", "b", "c"}}};
  const auto& [first, second, third] = kNames[static_cast<std::size_t>(*euler)];
  return fmt::format(",{0}_deg,{1}_deg,{2}_deg,sigma_{0}_deg,sigma_{1}_deg,sigma_{2}_deg", first, second, third);
}

std::string angle_columns(const BodyPose& pose, const std::optional<EulerConvention>& euler) {
  if (!euler) return {};
  const ToldAngles told = told_angles(pose.T_world_body.rotation, pose.covariance.bottomRightCorner<3, 3>(), *euler);
  return fmt::format(",{},{}", joined(Eigen::Vector3d(told.angles_deg.data()), 6),
                     joined(Eigen::Vector3d(told.sigma_deg.data()), 6));
}

std::string landmark_columns(const Fix& fix) {
  return fmt::format("{},{}", fix.world ? fix.world->used.size() : 0, fmt::join(fix.rejected, " "));
}

}  // namespace

WorldRows::WorldRows(const std::string& path, Kind kind, const WorldRowsOptions& options)
    : kind_(kind), options_(options) {
  if (path.empty()) return;
  file_.emplace(path);
  file_->write(
      fmt::format("frame,timestamp_ns,x_mm,y_mm,z_mm,qw,qx,qy,qz,sigma_x_mm,sigma_y_mm,sigma_z_mm,sigma_rot_deg,"
                  "ambiguity,landmarks_used,landmarks_rejected{}{}\n",
                  kind_ == Kind::kTrack ? ",vx_mm_s,vy_mm_s,vz_mm_s" : "", angle_names(options_.euler)));
}

bool WorldRows::has_row(Kind kind, const Fix& fix, double max_ambiguity) noexcept {
  if (kind == Kind::kWorld) return fix.world.has_value();
  return fix.track && fix.track->gated_frames == 0 && fix.track->ambiguity <= max_ambiguity;
}

void WorldRows::add(const Frame& frame, const Fix& fix) {
  if (!file_ || !has_row(kind_, fix, options_.max_ambiguity)) return;
  const auto write = [&](const WorldFromCamera& T, const Matrix6d& covariance, double ambiguity,
                         const std::string& velocity) {
    const BodyPose pose = shown_pose(T, covariance, options_.body, frame);
    file_->write(fmt::format("{},{},{},{:.6f},{}{}{}\n", frame.number, frame.exposed_at().time_since_epoch().count(),
                             pose_columns(pose), ambiguity, landmark_columns(fix), velocity,
                             angle_columns(pose, options_.euler)));
  };
  if (kind_ == Kind::kWorld) {
    write(fix.world->T_world_camera, fix.world->covariance, fix.world->ambiguity, "");
    return;
  }
  const TrackedPose& track = *fix.track;
  write(track.motion.T_world_camera, track.covariance.topLeftCorner<6, 6>(), track.ambiguity,
        fmt::format(",{}", joined(track.motion.velocity_m_s / kMetresPerMm, 3)));
}

}  // namespace ninedot
