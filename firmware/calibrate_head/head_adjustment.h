#pragma once
/// Bundle adjustment of a head: chain, tables, places of the landmarks and the true angles of every stop, from where
/// dots were seen and from what the head told.
///
/// A stop's true angles are unknowns of their own. What the head told ties them to the tables with the spread of a
/// servo, which is a hundred times what a picture is uncertain by: so the pictures say how the head is made, and the
/// told angles only how it is told about. B. Triggs et al., "Bundle Adjustment - A Modern Synthesis", 1999; solved by
/// Ceres Solver with the stops eliminated first.
#include <Eigen/Core>
#include <functional>

#include "calibrate_head/head_network.h"

namespace ninedot {

struct HeadAdjustmentOptions {
  bool is_robust = false;   ///< Cauchy's loss: what contradicts the rest loses its influence
  bool frees_skew = false;  ///< HeadNetwork::skew_rad is unknown too
  int max_iterations = 50;
  std::function<bool()> go_on;  ///< asked after every step; false ends the work where it is; may be empty
};

/// Moves what `network` counts, from where it is.
/// \return  false: nothing counts, it can't be evaluated, or it was told to stop
bool adjust_head(HeadNetwork& network, const HeadAdjustmentOptions& options);

/// Of the chain: tilt_axis_m.x, camera_m, and a rotation vector of the camera in the axes of the tilted head,
/// exp(rotation) R. [m, rad]
inline constexpr int kChainUnknowns = 7;

/// Covariances of what adjust_head finds, about where `network` is. \pre adjust_head was successful there (contract)
struct HeadCovariance {
  Eigen::Matrix<double, kChainUnknowns, kChainUnknowns> chain;  ///< [m^2, m rad, rad^2]
  double skew_rad2 = 0;                                         ///< variance; 0 unless it was freed
  Eigen::MatrixXd pan, tilt;                        ///< of the tables' values at their knots, and of the lag [rad^2]
  std::vector<double> pan_tie_rad2, tilt_tie_rad2;  ///< of each stop: variance of its angle less the table's; 0: does
                                                    ///< not count
};
HeadCovariance covariance_of_head(HeadNetwork& network, bool frees_skew);

/// A stop's true angle less the table's, the lag taken out. [rad] \param stop  index of it
HeadAngles tie_of(const HeadNetwork& network, std::size_t stop);

/// Of a sighting's dots, in the variance that they say of themselves. [1]
double chi2_of(const HeadNetwork& network, const StopSighting& sighting);

/// \return  two for each dot that is seen [1]
int residual_count(const LandmarkSighting& sighting);

}  // namespace ninedot
