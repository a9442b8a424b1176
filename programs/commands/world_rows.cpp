#include "programs/commands/world_rows.h"

#include <fmt/format.h>

#include <cmath>

#include "base/units.h"

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
std::string pose_columns(const WorldFromCamera& T_world_camera, const BodyCovariance& camera_covariance,
                         const std::optional<BodyGeometry>& geometry, const Frame& frame) {
  BodyPose pose{{T_world_camera.rotation, T_world_camera.translation_m}, camera_covariance};
  if (geometry)
    pose =
        body_in_world(T_world_camera, camera_covariance, camera_on_body(*geometry, frame.head.value_or(HeadAngles{})));
  const auto& [T, covariance] = pose;
  const Eigen::Quaterniond q = T.quaternion();
  const auto sigma_mm = [&covariance = pose.covariance](Eigen::Index axis) {
    return std::sqrt(covariance(axis, axis)) / kMetresPerMm;
  };
  return fmt::format("{},{},{},{:.6f},{:.6f},{:.6f},{:.6f}", joined(T.translation_m / kMetresPerMm, 6),
                     decimals(q.w(), 9), joined(q.vec(), 9), sigma_mm(0), sigma_mm(1), sigma_mm(2),
                     std::sqrt(covariance(3, 3) + covariance(4, 4) + covariance(5, 5)) / kRadPerDeg);
}

std::string landmark_columns(const Fix& fix) {
  if (!fix.world) return "0,";
  std::string rejected;
  for (const std::uint16_t id : fix.world->rejected) rejected += fmt::format("{}{}", rejected.empty() ? "" : " ", id);
  return fmt::format("{},{}", fix.world->used.size(), rejected);
}

}  // namespace

WorldRows::WorldRows(const std::string& path, Kind kind, double max_ambiguity, const std::optional<BodyGeometry>& body)
    : kind_(kind), max_ambiguity_(max_ambiguity), body_(body) {
  if (path.empty()) return;
  file_.emplace(path);
  file_->write(
      fmt::format("frame,timestamp_ns,x_mm,y_mm,z_mm,qw,qx,qy,qz,sigma_x_mm,sigma_y_mm,sigma_z_mm,sigma_rot_deg,"
                  "ambiguity,landmarks_used,landmarks_rejected{}\n",
                  kind_ == Kind::kTrack ? ",vx_mm_s,vy_mm_s,vz_mm_s" : ""));
}

bool WorldRows::has_row(Kind kind, const Fix& fix, double max_ambiguity) noexcept {
  if (kind == Kind::kWorld) return fix.world.has_value();
  return fix.track && fix.track->gated_frames == 0 && fix.track->ambiguity <= max_ambiguity;
}

void WorldRows::add(const Frame& frame, const Fix& fix) {
  if (!file_ || !has_row(kind_, fix, max_ambiguity_)) return;
  const std::string head = fmt::format("{},{}", frame.number, frame.exposed_at().time_since_epoch().count());
  if (kind_ == Kind::kWorld) {
    file_->write(fmt::format("{},{},{:.6f},{}\n", head,
                             pose_columns(fix.world->T_world_camera, fix.world->covariance, body_, frame),
                             fix.world->ambiguity, landmark_columns(fix)));
    return;
  }
  file_->write(fmt::format(
      "{},{},{:.6f},{},{}\n", head,
      pose_columns(fix.track->motion.T_world_camera, fix.track->covariance.topLeftCorner<6, 6>(), body_, frame),
      fix.track->ambiguity, landmark_columns(fix), joined(fix.track->motion.velocity_m_s / kMetresPerMm, 3)));
}

void WorldRows::finish() {
  if (file_) file_->finish();
}

}  // namespace ninedot
