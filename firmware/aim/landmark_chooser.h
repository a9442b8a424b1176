#pragma once
/// Which of the landmarks in a picture the head follows. Along a robot's way one hands over to the next; none does so
/// to and fro.
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "aim/aim_options.h"
#include "base/mono_time.h"

namespace ninedot {

/// A landmark in one frame.
struct AimSight {
  std::uint16_t id = 0;
  MonoTime exposed_at{};
  Eigen::Vector3d landmark_camera_m{0, 0, 1};  ///< the middle of P9, frame camera
};

/// Memory: inside. Threads: one.
class LandmarkChooser {
 public:
  /// \param options  `landmark`, `landmark_id`, `hand_over_margin`
  explicit LandmarkChooser(const AimOptions& options) noexcept;

  /// For each frame. \param sights  of one frame, the one whose pose is reported first
  /// \return  of `sights`; null: the one to follow is not there
  const AimSight* choose(std::span<const AimSight> sights) noexcept;

 private:
  const AimSight* change_to(const AimSight& sight) noexcept;

  LandmarkChoice choice_;
  std::uint16_t wanted_;
  double margin_;
  std::optional<std::uint16_t> current_;
  MonoTime seen_at_{};                   // of the current one
  std::optional<std::uint16_t> nearer_;  // by the margin
  MonoTime nearer_since_{};
};

}  // namespace ninedot
