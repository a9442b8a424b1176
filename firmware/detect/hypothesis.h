#pragma once
/// Guesses which blobs are the dots of a landmark. Every guess is checked against the grey levels afterwards
/// (verify.h), so that these may be generous.
#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "base/inline_vector.h"
#include "detect/blob_finder.h"
#include "geometry/landmark.h"

namespace ninedot {

/// A guess. The numbering of the ring may still be turned by any multiple of 45 degrees.
struct Hypothesis {
  Eigen::Matrix3d H_px_plane;                  ///< (u, v, 1) ~ H (X0, Z0, 1), px and m, lens distortion not regarded
  std::array<std::int16_t, kDotCount> blob{};  ///< index into the blob list, -1 where none fits
  int matched = 0;
};

inline constexpr std::size_t kMaxHypotheses = 96;
using HypothesisList = InlineVector<Hypothesis, kMaxHypotheses>;

/// Blobs must be sorted by area, largest first (contract of the three functions below).
void sort_by_area(BlobList& blobs) noexcept;

/// Takes each blob as P9: its ellipse says, under an affine map, on which ellipse the ring's dots lie and how large
/// they are; eight-fold symmetry around it picks them out. Three dots are enough.
void guess_from_centre(const BlobList& blobs, const LandmarkGeometry& landmark, HypothesisList& out) noexcept;

/// Takes three blobs as neighbours on the ring, when P9 is hidden or spoiled: three points give the affine map, the
/// area and shape of the middle one confirm it.
void guess_from_ring(const BlobList& blobs, const LandmarkGeometry& landmark, HypothesisList& out) noexcept;

/// Takes the dots from where H predicts them and fits H to what it found. \return false: fewer than three dots remain
bool attach_blobs(const BlobList& blobs, const LandmarkGeometry& landmark, Hypothesis& hypothesis) noexcept;

}  // namespace ninedot
