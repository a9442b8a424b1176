#pragma once
/// A camera's lens from views of a sheet of dots whose places on the sheet are known.
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "calibrate_camera/lens_adjustment.h"
#include "calibrate_camera/lens_uncertainty.h"

namespace ninedot {

struct LensCalibrationOptions {
  int width_px = 0, height_px = 0;       ///< of the pictures
  std::optional<DistortionModel> model;  ///< nothing: the simplest that the views support
  std::optional<CameraModel> guess;      ///< one more place to start from
  bool rough = false;                    ///< near enough to search with: no choice among models, no covariance
  /// Called now and then with what is going on; false ends the work. May be empty.
  std::function<bool(std::string_view what)> go_on;
};

/// How a lens model did in views that it was not fitted to.
struct TriedModel {
  DistortionModel model = DistortionModel::kPlumbBob;
  double held_out_px =
      0;  ///< root mean square of the outlines there, none counted as more than 1 px; infinite: it fits none
};

struct LensCalibration {
  LensFit fit;
  std::vector<SheetView> views;  ///< as fit.views
  LensCovariance covariance;
  DirectionErrors directions;
  double rms_px = 0;              ///< root mean square of the outlines' residuals, each by its certainty
  int left_out = 0;               ///< number of views that contradict the others or show no outline
  int contradicting = 0;          ///< number of those among them that contradict the others
  std::vector<TriedModel> tried;  ///< the best first; none: it was told which
};

/// \param views  distinct ones; their edges are measured here
/// \return  nothing: no lens explains them, or it was told to stop
std::optional<LensCalibration> calibrate_lens(std::span<const PlaneDisc> discs, std::vector<SheetView> views,
                                              const LensCalibrationOptions& options);

/// "plumb_bob" and so on, as camera.yaml has them.
std::string_view name_of(DistortionModel model) noexcept;

}  // namespace ninedot
