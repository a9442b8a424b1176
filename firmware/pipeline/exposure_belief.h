#pragma once
/// How long pictures are exposed that do not say so, as recordings: by how long the lines are that landmarks draw,
/// beside how fast they move.
#include <cmath>
#include <optional>

namespace ninedot {

/// Memory: none. Threads: one caller.
class ExposureBelief {
 public:
  /// A landmark's outlines. \param speed_px_s  of its middle through the picture
  /// \param along_px2  half of what the variance of its blur along the motion is more than that across
  void note(double speed_px_s, double along_px2) noexcept {
    // A line of even brightness has a twelfth of its length's square as variance: 24 of these halves are s^2 t^2. By
    // least squares; who moves fast says most.
    const double speed2 = speed_px_s * speed_px_s;
    speed4_ = kKept * speed4_ + speed2 * speed2;
    product_ = kKept * product_ + 24 * along_px2 * speed2;
  }

  /// [s]; none: nothing has moved fast enough to tell
  std::optional<double> exposure_s() const noexcept {
    if (!(product_ > 0)) return std::nullopt;
    const double exposure2_s2 = product_ / speed4_, sigma_s2 = 24 * kSigma_px2 / std::sqrt(speed4_);
    if (!(exposure2_s2 > kClear * sigma_s2)) return std::nullopt;
    return std::sqrt(exposure2_s2);
  }

 private:
  static constexpr double kKept = 0.98;       // of what was known, by each landmark: an automatic exposure changes
  static constexpr double kSigma_px2 = 0.15;  // of one landmark's blur along less across, and what a lens makes of it
  static constexpr double kClear = 6;

  double speed4_ = 0, product_ = 0;
};

}  // namespace ninedot
