#pragma once
/// Rendered trials of every solver under one condition, beside the Cramer-Rao bound.
#include <cstdint>
#include <string>

#include "geometry/camera_model.h"
#include "tests/support/renderer.h"

namespace ninedot::bench {

/// One row of a table. The viewing azimuth, the roll (within 15 degrees),
/// the place within a degree, the wall and the side from which a board comes are drawn anew for each trial.
struct Condition {
  std::string label;
  double plot_x = 0;  ///< the label's number, for the plot
  double distance_m = 1.5;
  double tilt_rad = 0.436;  ///< 25 degrees
  double noise_at_grey128_lsb = 2;
  double hidden_fraction = 0;
  double off_axis_rad = 0;  ///< to the left or right of the optical axis
  bool distorted = false;   ///< plumb_bob k1 = -0.12, k2 = 0.05, p1 = 0.0008, p2 = -0.0005
  test::ToneCurve tone = test::ToneCurve::kSrgb;
  double light_gradient_per_m = 0;
  bool hard_shadow = false;  ///< a band of shade over a third of the sheet, 30 % of the light left
  double veil = 0;
};

/// How one solver did. Root mean squares are over the trials whose pose is not `wrong`.
struct SolverOutcome {
  int poses = 0;     ///< trials in which it gave one
  int wrong = 0;     ///< of these: the other solution of the planar ambiguity, or a ring dot taken for its neighbour
  double rms_m = 0;  ///< error of the position, the three axes together
  double rms_ratio = 0;  ///< the same, each error over its own frame's bound: 1 is the limit
  double nees = 0;       ///< mean of e^T covariance^-1 e over 6 degrees of freedom: 6 is honest, more is overconfident
};

struct Outcome {
  int trials = 0;
  int found = 0;       ///< by the detector
  double bound_m = 0;  ///< root mean square of the frames' bounds
  SolverOutcome full, ellipse;
};

/// The product's camera from the renderer's lens.
CameraModel camera_of(const test::Lens& lens);

/// The frame of one trial; the same numbers give the same frame.
test::Scene scene_of(const Condition& condition, std::uint64_t seed);

/// Threads: independent of each other; a call uses its own detector and solvers.
Outcome run_trials(const Condition& condition, int trials, std::uint64_t seed);

}  // namespace ninedot::bench
