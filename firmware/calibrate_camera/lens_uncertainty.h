#pragma once
/// How well a calibration knows its lens.
#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibrate_camera/lens_adjustment.h"

namespace ninedot {

struct LensCovariance {
  /// In the order of parameters_of: [px^2], [px], [1]
  Eigen::MatrixXd matrix;
  /// By how much the views' say on the lens spreads more than their outlines' sigmas explain, as a variance; it is in
  /// `matrix` already. 1: all of it is explained. [1]
  double variance_factor = 1;
};

/// Inverse of the information that is left on the lens once each view's own unknowns are eliminated, times a factor:
/// what a model leaves unexplained is not the same in all views but much alike within one, so views are what is counted
/// (a sandwich estimate with one scalar: P. J. Huber, 1967; clusters as in K.-Y. Liang & S. L. Zeger, Biometrika 1986).
LensCovariance lens_covariance(std::span<const PlaneDisc> discs, std::span<const SheetView> views, const LensFit& fit);

/// Expected error of the direction that a pixel is taken to look along, in pixels, over the picture.
///
/// A rotation that is common to all pixels is left out: no view can tell it from a turn of the camera, and every pose
/// takes it up. As D. Kogan's mrcal does ("projection uncertainty", mrcal.secretsauce.net).
struct DirectionErrors {
  static constexpr int kColumns = 24, kRows = 18;
  int width_px = 0, height_px = 0;
  std::vector<double> sigma_px;  ///< row by row; root of the summed variances along x and y. Infinite: no inverse there
  /// \return  [px]
  double at(int column, int row) const {
    return sigma_px[static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column)];
  }
  Eigen::Vector2d pixel_px(int column, int row) const;
  // Over the pixels that have a direction.
  double median_px() const;
  double max_px() const;
};

/// \param covariance  as LensCovariance::matrix [px^2], [px], [1]
DirectionErrors direction_errors(const CameraModel& camera, const Eigen::MatrixXd& covariance);

/// What two lenses differ by in the directions of pixels, a common rotation left out likewise: from `a` to `b` where
/// the pixels of the grid are; infinite where a lens has no inverse. [px]
DirectionErrors direction_differences(const CameraModel& a, const CameraModel& b);

}  // namespace ninedot
