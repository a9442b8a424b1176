#include "track/lone_stand.h"

namespace ninedot {

void LoneStand::note(std::optional<std::size_t> landmark, const WorldPrior* before,
                     const WorldFromCamera& T_world_camera, const PoseCovariance& covariance) noexcept {
  if (landmark && landmark == landmark_ && before != nullptr) return;
  landmark_ = landmark;
  before_.reset();
  if (before != nullptr)
    before_ = WorldPrior{
        .T_world_camera = before->T_world_camera, .covariance = before->covariance, .ambiguity = before->ambiguity};
  T_world_camera_ = T_world_camera;
  covariance_ = covariance;
}

// How the camera has moved since then one landmark tells as well where it does not hang in its place: what was known
// then moves along, and so does its error, as a whole.
void LoneStand::complete(WorldPrior& prior, WorldPrior& without) const noexcept {
  prior.stands_on = landmark_;
  if (!landmark_ || !before_) return;
  const WorldFromCamera& before = before_->T_world_camera;
  without = WorldPrior{.T_world_camera = before * T_world_camera_.inverse() * prior.T_world_camera,
                       .ambiguity = before_->ambiguity};
  const Eigen::Vector3d way_m = without.T_world_camera.translation_m - before.translation_m;
  Eigen::Matrix3d across;
  across << 0, -way_m.z(), way_m.y(), way_m.z(), 0, -way_m.x(), -way_m.y(), way_m.x(), 0;
  PoseInformation moved = PoseInformation::Identity();
  moved.topRightCorner<3, 3>() = -across * before.rotation;
  moved.bottomRightCorner<3, 3>() = without.T_world_camera.rotation.transpose() * before.rotation;
  without.covariance = moved * (before_->covariance + covariance_) * moved.transpose() + prior.covariance;
  prior.without = &without;
}

}  // namespace ninedot
