#pragma once
/// What a pose solver answers.
#include <Eigen/Core>
#include <array>
#include <optional>

#include "base/inline_vector.h"
#include "geometry/dot_sighting.h"
#include "geometry/landmark.h"
#include "geometry/optimiser_statistics.h"
#include "geometry/transform.h"
#include "pose/outline_state.h"

namespace ninedot {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The quantities of the founding paper (Martin & Adan, Pattern Recognition 45 (2012) 578-595, section 3), reported by
/// every solver.
struct EllipseParameters {
  double swing_psi_rad = 0;     ///< between the ring ellipse's major axis and the picture's vertical
  double tilt_phi_rad = 0;      ///< between the line of sight and the sheet's normal
  double pan_theta_rad = 0;     ///< position of the dots along the ellipse
  double distance_m = 0;        ///< D: from P9 to the optical centre
  double image_distance_m = 0;  ///< D' = D + f: from P9 to the image plane
  double deviation_rad = 0;     ///< delta: between the optical axis and the direction to P9 (27)
};

struct PoseEstimate {
  Transform<frame::Landmark, frame::Camera> T_landmark_camera;
  /// Of (position in S0 [m], rotation vector in the camera frame [rad]): R_true = R exp(rotation), t_true = t +
  /// position.
  Matrix6d covariance = Matrix6d::Zero();
  double ambiguity = 0;     ///< 0 = other readings of the picture are excluded, 1 = another fits alike
  double rms_px = 0;        ///< residual of the outlines used: root mean square, each by its certainty [px]
  int dots_used = 0;        ///< of nine, partly hidden ones included
  int occlusion_level = 0;  ///< 0 nothing hidden, I..III of the founding paper as 1..3
  EllipseParameters ellipse;
};

/// How the picture's grey levels agree with outlines where a pose has them.
struct OutlineFit {
  double contrast_lsb = 0;  ///< of paper and ink, the median group of pixels [LSB]
  double paper_lsb = 0;     ///< likewise the paper's grey level [LSB]
  /// 1-sigma of the pixels about the model [LSB], of the quantile of the groups that the weights take for noise:
  /// shadows may spoil two thirds of them.
  double residual_lsb = 0;
};

/// How far the outlines lie from those of discs of the landmark's sizes, in shares of the radius that a disc as large
/// as a dot of the ring would have in the picture, 0.. (outline_shape.h).
struct OutlineShape {
  bool is_unknown = false;   ///< somebody has looked, and too few outlines are sure enough to tell: but P9's corners,
                             ///< the shares are 0
  double size = 0;           ///< some larger than others against the landmark's: of the median dot [1]
  double second = 0;         ///< longer one way than the other: amplitude of the median dot, of its short semi-axis [1]
  double fourth = 0;         ///< with four corners: likewise [1]
  double centre = 0;         ///< P9 aside [1]
  double centre_size = 0;    ///< P9 larger or smaller than the ring's dots against the landmark's [1]
  double centre_fourth = 0;  ///< P9 with four corners: of its own short semi-axis [1]
  double centre_ink = 1;     ///< how dark P9 is, in shares of the ring's dots: paler where it is too small [1]
  int absent = 0;            ///< dots that are not there, though nothing hides them [1]
  int hollow = 0;            ///< dots that are no ink in their middle [1]
  int spots = 0;             ///< of ink on the blank paper between P9 and a whole ring [1]
};

/// One reading of a picture.
struct PoseCandidate {
  PoseEstimate pose;  ///< `ambiguity` is left to who chooses
  /// How much worse this reading explains the picture than the best of them: difference of chi^2, so that the odds
  /// against it are exp(chi2_above / 2). 0 for the best. [1]
  double chi2_above = 0;
  /// false: it was excluded without a fit of its own, and chi2_above is what excluded it. Its pose is rough, its
  /// covariance unknown: never to be chosen.
  bool refined = true;
  OptimiserStatistics statistics;                 ///< of its refinement
  OutlineFit fit;                                 ///< of its outlines; solver "full"
  DotSightings dots;                              ///< what each of its outlines says by itself
  OutlineShape shape;                             ///< likewise; 0 but in the best of a search's answer
  double dot_radius_px = 0;                       ///< of the ring's dots, likewise, seen from in front
  double centre_radius_px = 0;                    ///< of P9, likewise
  double offset_sigma_px = 0;                     ///< 1-sigma of outlines.offset_px
  OutlineState outlines;                          ///< solver "full": what a next frame may start from
  std::array<double, kDotCount> visible_share{};  ///< of each dot's outline, where it belongs. 0..1
};

/// The mirror image beside the pose: all readings that the points of one plane allow.
inline constexpr std::size_t kMaxPoseCandidates = 2;

/// Another reading than the chosen one, numbering included.
struct RivalReading {
  Transform<frame::Landmark, frame::Camera> T_landmark_camera;
  double odds = 0;  ///< that it is the right one, 0..1
};

/// What a solver answers: every reading, the best one first. Who chooses among them is the track.
struct PoseCandidates {
  InlineVector<PoseCandidate, kMaxPoseCandidates> list;  ///< at least one
  double warp_px = 0;                                    ///< how far the dots lay from where one flat sheet shows them
  /// The likeliest reading beside the chosen one, planar solutions and numberings together; none: no other is possible.
  std::optional<RivalReading> rival;
};

/// Difference of chi^2 below which the picture can't tell two readings apart: 3 sigma. [1]
inline constexpr double kUndecided_chi2 = 9;

/// A dot counts as used from this visible share of its outline on: a third of an outline still fixes its place across
/// two directions.
inline constexpr double kMinVisible = 0.3;

}  // namespace ninedot
