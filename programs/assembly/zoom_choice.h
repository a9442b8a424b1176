#pragma once
/// Which lens of a zoom camera's calibration a program works with: the one of a fixed position, or at each frame the
/// one of the position that somebody tells.
#include <memory>
#include <optional>

#include "calibrate/camera_file.h"
#include "config/config.h"
#include "pipeline/localiser.h"

namespace ninedot {

/// Whether the head of a configuration says at which zoom its lens stands.
bool head_tells_zoom(const PanTiltConfig& head) noexcept;

/// Leaves `zoom` in the calibration where positions are followed, `camera` being that of [pan_tilt] zoom, else the
/// widest. Where nobody tells them the calibration becomes that of [pan_tilt] zoom, and `zoom` goes. One without a zoom
/// stays as it is. \param is_told  the head or the frames tell their zoom
/// Throws StartupError(kWrongUsage): nobody tells it and there is no fixed one, or the calibration does not reach it.
void choose_zoom(CameraCalibration& calibration, const PanTiltConfig& head, bool is_told);

/// For the localiser that `options` make. \param lens  of a ZoomTable. Allocates; not for the frame loop.
std::unique_ptr<Lens> make_lens(const ZoomLens& lens, const LocaliserOptions& options);

/// Lenses between two frames, for who has time to wait for them: before each frame the one that it was taken through.
/// Memory: allocates. Threads: one, the localiser's.
class LensesByFrame {
 public:
  /// \param zoom, options  must outlive this; LocaliserOptions::new_lenses is there (contract)
  LensesByFrame(const ZoomTable& zoom, const LocaliserOptions& options) : zoom_(zoom), options_(options) {}

  /// \return  the camera that the frame was taken with; nothing: its zoom is not known, or out of reach
  std::optional<CameraModel> serve(const Frame& frame);

 private:
  const ZoomTable& zoom_;
  const LocaliserOptions& options_;
  std::optional<ZoomLens> served_;
};

}  // namespace ninedot
