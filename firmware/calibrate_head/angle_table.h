#pragma once
/// An axis's true angle over the one that it tells.
#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace ninedot {

/// Linear between knots, and on beyond the outer ones. Memory: allocates. Threads: as a value.
struct AngleTable {
  std::vector<double> told_rad;   ///< knots, rising, two at least
  std::vector<double> angle_rad;  ///< true angles there, in the middle of the play
  double lag_rad = 0;             ///< half the play: the camera stays behind by so much, from whichever side it came

  double at(double told) const;  ///< \param told  [rad] \return  [rad]
};

/// What the knots' values count at a told angle: at(told) is this times the values. Two are not 0.
/// \param knots_rad  as AngleTable::told_rad \return  [1]
Eigen::VectorXd knot_weights(std::span<const double> knots_rad, double told_rad);

/// The told angle whose true one is taken to be the same, since what the foot's own turn is nobody can see: 0, or of
/// the knots' range the end that is nearest to it. [rad]
double anchor_rad(std::span<const double> knots_rad);

/// One stop of an axis.
struct AxisStop {
  double told_rad = 0, angle_rad = 0;  ///< the latter as the pictures have it
  int side = 0;                        ///< as HeadStop::pan_side; 0: the play counts nothing [1]
};

/// How many knots, evenly spaced over what was told, the stops ask for: the fewest with which stops that were left out
/// are foretold within 3 % of the best.
/// \param stops  five at least (contract)
/// \return  knots [rad]
std::vector<double> choose_knots(std::span<const AxisStop> stops);

/// `count` knots from the lowest to the highest told angle. [rad] \pre count >= 2 (contract)
std::vector<double> even_knots(std::span<const AxisStop> stops, std::size_t count);

}  // namespace ninedot
