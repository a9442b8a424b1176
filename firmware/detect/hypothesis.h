#pragma once
/// Guesses which blobs are the dots of a landmark. Every guess is checked against the grey levels afterwards
/// (verify.h), so that these may be generous.
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/inline_vector.h"
#include "detect/blob.h"
#include "detect/blob_grid.h"
#include "geometry/landmark.h"

namespace ninedot {

/// A guess. The numbering of the ring may still be turned by any multiple of 45 degrees.
struct Hypothesis {
  Eigen::Matrix3d H_px_plane;                  ///< (u, v, 1) ~ H (X0, Z0, 1), px and m, lens distortion not regarded
  std::array<std::int16_t, kDotCount> blob{};  ///< index of its blob in the list, -1 where none fits
  int matched = 0;
};

/// Guesses from a centre were 3 at most in the developers' pictures; guesses from three dots of the ring fill the list
/// in rooms with many spots (tried only where no centre led to a landmark), and those with fewer dots give way.
inline constexpr std::size_t kMaxHypotheses = 96;
using HypothesisList = InlineVector<Hypothesis, kMaxHypotheses>;

/// Blobs sorted by area, largest first, and by place: what the functions below search.
class SortedBlobs {
 public:
  /// \param width_px, height_px  of the largest picture. Memory: the constructor's.
  SortedBlobs(int width_px, int height_px) : grid_(width_px, height_px) {}

  /// Sorts `blobs`, which must outlive the next searches unchanged.
  void assign(BlobList& blobs) noexcept;

  const BlobList& list() const noexcept { return *blobs_; }

  /// How many have at least this area: the first of the list.
  std::size_t count_from(float area_px2) const noexcept;

  /// Calls use(index, blob) for blobs of an area between the bounds, not further than `reach_px` in x and in y.
  template <typename Use>
  void for_each_near(float x_px, float y_px, float reach_px, double low_px2, double high_px2,
                     Use&& use) const noexcept {
    const auto low = static_cast<float>(low_px2), high = static_cast<float>(high_px2);
    grid_.for_each_near(x_px, y_px, reach_px, [&](std::size_t i) {
      const Blob& blob = (*blobs_)[i];
      if (blob.area_px2 < low || blob.area_px2 > high || std::abs(blob.x_px - x_px) > reach_px ||
          std::abs(blob.y_px - y_px) > reach_px)
        return;
      use(i, blob);
    });
  }

 private:
  const BlobList* blobs_ = nullptr;
  BlobGrid grid_;
};

/// What found no room in a list of fixed size, added up over all calls; wraps.
struct GuessCuts {
  std::uint32_t neighbours = 0;  ///< blobs around P9, or beside a dot of the ring
  /// Blobs that no guess began with, for want of allowance; and of a full list and a new guess the one with fewer dots.
  std::uint32_t hypotheses = 0;
};

/// Ranks [1] of the blobs at which guessing begins; where it ended in the picture before for want of allowance.
struct GuessBegin {
  std::size_t centre = 0, middle = 0;  ///< of guess_from_centre, of guess_from_ring [1]
};

/// Takes each blob as P9, the largest first: its ellipse says, under an affine map, on which ellipse the ring's dots
/// lie and how large they are; eight-fold symmetry around it picks them out. Three dots are enough.
///
/// \param allowance  [1] guesses that may be tried; fewer afterwards
/// \param begin_at  [1] rank of the blob to begin with, and around to the one before it. Afterwards: where it ran out
/// of allowance, 0 where it got through
/// \return  whether it got through
bool guess_from_centre(const SortedBlobs& blobs, const LandmarkGeometry& landmark, int& allowance,
                       std::size_t& begin_at, HypothesisList& out, GuessCuts& cuts) noexcept;

/// Takes three blobs as neighbours on the ring, when P9 is hidden or spoiled: three points give the affine map, the
/// area and shape of the middle one confirm it.
/// \param allowance, begin_at  as above [1]
bool guess_from_ring(const SortedBlobs& blobs, const LandmarkGeometry& landmark, int& allowance, std::size_t& begin_at,
                     HypothesisList& out, GuessCuts& cuts) noexcept;

/// Takes the dots from where H predicts them and fits H to what it found. \return false: fewer than three dots remain
bool attach_blobs(const SortedBlobs& blobs, const LandmarkGeometry& landmark, Hypothesis& hypothesis) noexcept;

}  // namespace ninedot
