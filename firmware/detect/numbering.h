#pragma once
/// Which of the ring's eight dots is P1.
///
/// The ring looks the same after an eighth of a turn: eight numberings, each of which makes another camera. One picture
/// has only priors to go by: a camera stands upright (but for the expected roll) and not far above or below the
/// landmark, so P1 is the dot that needs the least roll and elevation together: seen from in front the lowest dot. From
/// diagonally above the lowest dot may be a neighbour, and roll tells them apart; from 75 degrees aside neighbours
/// differ by 15 degrees of roll, but by 40 of elevation. A track has more: where each dot was in the frame before.
#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "geometry/landmark.h"
#include "geometry/plane_point.h"
#include "geometry/upright_prior.h"

namespace ninedot {

/// What the priors say against dot k being P1: (roll / sigma)^2 + (elevation / sigma)^2 of the camera that it would
/// make, the smallest taken off.
/// \param points  of the dots that are seen, as rays; with four or more their rigid pose is used, for a distant
/// landmark's homography has eight unknowns of which two are noise
/// \param H_ray_plane  sheet [m] to bearing (z = 1), as in LandmarkObservation: used where there are fewer
/// \return  squares of normal deviates [1]
/// Memory: none. Threads: pure.
NumberingCosts numbering_costs(std::span<const PlanePoint> points, const Eigen::Matrix3d& H_ray_plane,
                               const LandmarkGeometry& landmark, const UprightPrior& prior) noexcept;

/// The dot that lies where P1 is foretold: of all eight numberings the one whose dots are nearest to the forecast ones,
/// by the sum of squared distances around P9, so that the landmark's way across the picture does not count. A turn by
/// more than 22.5 degrees between two frames cannot be told from another numbering: it is an alternative, never taken
/// for a motion.
/// \param H_ray_plane  of the dots as they are numbered now: sheet [m] to bearing (z = 1)
/// \param H_ray_plane_forecast  as they should be, likewise (z = 1)
/// \return  none: no numbering has them within kForecastMet; this is another view than the one foretold
/// Memory: none. Threads: pure.
std::optional<int> first_dot_by_forecast(const Eigen::Matrix3d& H_ray_plane,
                                         const Eigen::Matrix3d& H_ray_plane_forecast,
                                         const LandmarkGeometry& landmark) noexcept;

/// Root mean square of the ring dots' distances from their forecast, in units of the ring's own radius (both as seen
/// around P9): a turn by 8.6 degrees alone, or 15 % nearer. Between consecutive frames of the recordings `motion` and
/// `approach` it was 0.04 at most and 0.08 over three frames, 0.095 where 40 % were hidden; between the unrelated
/// pictures of `positions`, `range` and `plastic` 0.18 at least.
inline constexpr double kForecastMet = 0.15;

}  // namespace ninedot
