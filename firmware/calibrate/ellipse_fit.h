#pragma once
/// The founding paper's off-line calibration, from shots at known distances: Kmm, p1..p3, cu and cv of Martin & Adan,
/// Pattern Recognition 45 (2012) 578-595, equations (6) to (10) and (32) to (34).
#include <cstdint>
#include <optional>
#include <span>

#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "pose/ellipse_sight.h"
#include "pose/ellipse_solver.h"

namespace ninedot {

/// One picture of the landmark.
struct EllipseShot {
  std::uint64_t frame = 0;
  double distance_m = 0;  ///< D: from the middle of P9 to the optical centre, > 0
  /// Of an off-centre shot: the frame that was taken from the same place with P9 in the middle of the picture.
  std::optional<std::uint64_t> centred_frame;
  EllipseSight sight;
};

struct EllipseFit {
  EllipseCalibration calibration;
  std::size_t centred = 0, off_centre = 0;  ///< number of shots [1]
  bool depends_on_distance = false;         ///< false: the shots show no F that changes with D', and p2 = p3 = 0
  /// Of the distances of the centred shots as the solver has them then, relative: root mean square and largest. [1]
  double rms_share = 0, worst_share = 0;
};

/// Kmm is the mean of f R / ((D'_i - f) a_i) (7). F(D'_i) = f R / (a_i D_i) with the f = fx Kmm that the solver uses,
/// so that (8) gives the distances back; p1, p2, p3 by least squares, linear in p1 and p2, over p3 from -4 to 4; a
/// constant where that explains the shots as well. cu, cv by linear least squares: off-centre shots, stretched by (32)
/// and (33), have the ring of the centred one (34). \param shots  centred ones, at four distances or more, and
/// off-centre ones, in any order \param focal_length_mm  of the lens, > 0 (contract) Throws StartupError(kWorkFailed),
/// one line that names the frame and what to do: too few distances, a dot of the ring hidden, a landmark that is not
/// where the shot says, distances that contradict the pictures. Memory: allocates.
EllipseFit fit_ellipse_calibration(std::span<const EllipseShot> shots, const CameraModel& camera,
                                   const LandmarkGeometry& landmark, double focal_length_mm);

}  // namespace ninedot
