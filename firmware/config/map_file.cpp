#include "config/map_file.h"

#include <fmt/format.h>

#include <cmath>

#include "base/contract.h"
#include "base/units.h"

namespace ninedot {
namespace {

constexpr double kMmPerMetre = 1 / kMetresPerMm;

/// Rounded up to four digits after the point, in mm or degrees.
double sigma(double variance, double per_unit) { return std::ceil(std::sqrt(variance) * per_unit * 1e4) / 1e4; }

std::string sigmas(const char* key, const Eigen::Vector3d& variances, double per_unit) {
  return fmt::format("{} = [{:.4f}, {:.4f}, {:.4f}]\n", key, sigma(variances.x(), per_unit),
                     sigma(variances.y(), per_unit), sigma(variances.z(), per_unit));
}

}  // namespace

std::string format_map(std::span<const MappedLandmark> landmarks, std::span<const std::string> comment,
                       std::span<const std::string> notes) {
  EXPECTS(notes.size() == landmarks.size());
  std::string text;
  for (const std::string& line : comment) text += fmt::format("# {}\n", line);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const MappedLandmark& landmark = landmarks[i];
    text += fmt::format("\n[[landmarks]]{}\nid = {}\n", notes[i].empty() ? "" : "  # " + notes[i], landmark.id);
    if (!landmark.code.empty()) text += fmt::format("code = \"{}\"\n", landmark.code);
    if (!landmark.has_place) continue;
    const Eigen::Vector3d p_mm = landmark.T_world_landmark.translation_m * kMmPerMetre;
    const Eigen::Quaterniond q = landmark.T_world_landmark.quaternion();
    text += fmt::format("position_mm = [{:.3f}, {:.3f}, {:.3f}]\n", p_mm.x(), p_mm.y(), p_mm.z());
    text += fmt::format("orientation_wxyz = [{:.9f}, {:.9f}, {:.9f}, {:.9f}]  # heading {:.2f} deg\n", q.w(), q.x(),
                        q.y(), q.z(), heading_rad(landmark.T_world_landmark) * kDegPerRad);
    if (landmark.from_pictures) text += "from_pictures = true\n";
    if (landmark.covariance.isZero(0)) continue;
    text += sigmas("sigma_position_mm", landmark.covariance.diagonal().head<3>(), kMmPerMetre);
    text += sigmas("sigma_rotation_deg", landmark.covariance.diagonal().tail<3>(), kDegPerRad);
  }
  return text;
}

}  // namespace ninedot
