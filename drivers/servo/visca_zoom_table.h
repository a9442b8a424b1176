#pragma once
/// The focal length of a zoom lens, from the position that the camera reports.
#include <array>
#include <cstddef>
#include <span>

namespace ninedot {

struct ZoomPoint {
  int zoom = 0;  ///< position [steps], 0: wide
  double focal_length_mm = 0;
};

/// Piecewise linear between the points; at and beyond an end, that end's. Memory: inside. Threads: never changed after
/// construction, so any may call anything; nothing waits.
class ViscaZoomTable {
 public:
  static constexpr std::size_t kMaxPoints = 32;  ///< room for one every 33 of an EVI-D31's 1024 steps

  /// Throws StartupError(kWrongUsage) with what is wrong, unless it gets 2 to kMaxPoints points of 0..65535 whose
  /// positions and focal lengths, beginning above 0, rise strictly.
  explicit ViscaZoomTable(std::span<const ZoomPoint> points);

  /// \param zoom  [steps]
  double focal_length_mm_at(int zoom) const noexcept;
  /// The two ends [steps].
  int min_zoom() const noexcept { return points_[0].zoom; }
  /// [steps]
  int max_zoom() const noexcept { return points_[count_ - 1].zoom; }

 private:
  std::array<ZoomPoint, kMaxPoints> points_{};
  std::size_t count_;
};

}  // namespace ninedot
