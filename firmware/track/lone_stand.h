#pragma once
/// A track that goes on by one landmark alone goes where that one says. Whether the landmark hangs where the map has it
/// such a track can't tell: that is left to what was known before.
#include <cstddef>
#include <optional>

#include "world/world_pose.h"

namespace ninedot {

/// Memory: none beyond itself. Threads: one caller.
class LoneStand {
 public:
  /// A picture entered the track. \param landmark  index, where it shows this one alone [1]; none: several
  /// \param before  what was expected until then; null: nothing \param T_world_camera  by the picture alone
  /// \param covariance  its own, of a PoseStep [m^2, m rad, rad^2]
  void note(std::optional<std::size_t> landmark, const WorldPrior* before, const WorldFromCamera& T_world_camera,
            const PoseCovariance& covariance) noexcept;
  void forget() noexcept { landmark_.reset(); }

  /// The one that the track stands on, and what is expected without it. `prior` is completed by both.
  /// \param without  room for the latter; must outlive the prior
  void complete(WorldPrior& prior, WorldPrior& without) const noexcept;

 private:
  std::optional<std::size_t> landmark_;
  // When it began to stand on that one:
  std::optional<WorldPrior> before_;
  WorldFromCamera T_world_camera_;  // by that one, and not by the track, which had not yet left what was before
  PoseCovariance covariance_ = PoseCovariance::Zero();
};

}  // namespace ninedot
