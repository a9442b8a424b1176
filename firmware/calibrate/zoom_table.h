#pragma once
/// The lens of a zoom camera over the positions of its zoom, from calibrations at some of them.
///
/// Between positions fx and fy go by their logarithms, the centre as it is, and each coefficient times the power of 1/f
/// that its term has: what it does in pixels, which changes smoothly where the coefficients themselves grow with f^2
/// and f^4. Each of these follows the smoothest curve through its values (a cubic spline whose outer pieces go on as
/// one cubic each), which is a weighted sum of them, so that their covariances carry over exactly.
///
/// How far the curve is off between positions the positions themselves say: each inner one is foretold from the others.
/// What lies between is taken for an integrated random walk of that strength (G. Wahba, J. Royal Statistical Society
/// B 40, 1978): its error grows with the width of the gap to the power of 3/2.
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera_gradients.h"

namespace ninedot {

/// The lens at one position.
struct ZoomLens {
  int zoom = 0;  ///< position, in the steps that the camera counts in
  CameraModel camera;
  IntrinsicCovariance covariance = IntrinsicCovariance::Zero();  ///< [px^2, px, 1]
};

/// An inner position as the others foretell it.
struct HeldOutZoom {
  int zoom = 0;  ///< [steps]
  CameraModel foretold;
};

/// A part between two positions that are next to each other, where the focal length is foretold worst.
struct ZoomGap {
  int from = 0, to = 0;    ///< [steps]
  int worst = 0;           ///< [steps] between the two
  double focal_sigma = 0;  ///< 1-sigma of the focal length there, as a share of it
};

/// What is wrong with positions as such, in one line; nothing: a ZoomTable can be made of them. They are fewer than two
/// or more than kMostZooms, repeat each other, have different sizes or models, or focal lengths that do not rise or
/// fall with the position. \param lenses  by rising position
std::optional<std::string> what_zooms_lack(const std::vector<ZoomLens>& lenses);
inline constexpr std::size_t kMostZooms = 64;

/// Memory: allocates; not for the frame loop. Threads: const is safe.
class ZoomTable {
 public:
  /// From so many positions on [1] the lens is known between them; with fewer at them alone: of one or two inner
  /// positions one is foretold well by chance too often, and then nothing tells how far the others are off.
  static constexpr std::size_t kLeastForBetween = 5;

  /// \param lenses  by rising position, of which what_zooms_lack says nothing (contract)
  explicit ZoomTable(std::vector<ZoomLens> lenses);

  const std::vector<ZoomLens>& lenses() const noexcept { return lenses_; }
  bool knows_between() const noexcept { return lenses_.size() >= kLeastForBetween; }

  /// The lens at a position, with all that is uncertain of it: the calibrations, the curve between them, and half a
  /// step to which the camera rounds its position. \param zoom  [steps] \return  nothing: the table does not reach it
  std::optional<ZoomLens> at(int zoom) const;

  /// "0 to 1023", or "0, 512 and 1023 alone".
  std::string reach() const;

  /// The one with the shortest focal length.
  const ZoomLens& widest() const noexcept;

  /// Every inner position from all others. \pre knows_between() (contract)
  std::vector<HeldOutZoom> held_out() const;

  /// \pre knows_between() (contract)
  ZoomGap worst_gap() const;

  /// Two positions between which the curve of the focal length turns back; nothing: it rises or falls all along.
  /// \pre knows_between() (contract)
  std::optional<ZoomGap> turning_gap() const;

 private:
  ZoomLens between(double zoom) const;

  std::vector<ZoomLens> lenses_;
  std::vector<IntrinsicCovariance> strengths_;  // of the walk in each gap, of the curve's values; none: too few
};

/// What is wrong between the positions, in one line; nothing: the table may be used. The focal length turns back, or is
/// foretold to no better than 1 %: distances are off by as much. One that knows nothing between lacks nothing there.
std::optional<std::string> what_gaps_lack(const ZoomTable& table);

}  // namespace ninedot
