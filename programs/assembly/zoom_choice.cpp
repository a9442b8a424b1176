#include "programs/assembly/zoom_choice.h"

#include <fmt/format.h>

#include <cmath>

#include "base/contract.h"
#include "base/startup_error.h"
#include "programs/assembly/make_localiser.h"

namespace ninedot {

bool head_tells_zoom(const PanTiltConfig& head) noexcept { return head.driver == "visca"; }

void choose_zoom(CameraCalibration& calibration, const PanTiltConfig& head, bool is_told) {
  if (!calibration.zoom) return;
  if (head.zoom < 0) {
    if (is_told) return;
    throw StartupError(ExitStatus::kWrongUsage,
                       "the calibration is that of a zoom lens, and nothing tells where its zoom stands: set zoom of "
                       "[pan_tilt] to the position that it is locked at");
  }
  const std::optional<ZoomLens> lens = calibration.zoom->at(head.zoom);
  if (!lens)
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("zoom {} of [pan_tilt] is out of the calibration's reach, {}; "
                                   "record one there, or zoom to where it reaches",
                                   head.zoom, calibration.zoom->reach()));
  calibration.camera = lens->camera;
  calibration.record.covariance = lens->covariance;
  if (!is_told) calibration.zoom.reset();
}

std::unique_ptr<Lens> make_lens(const ZoomLens& lens, const LocaliserOptions& options) {
  SeekerOptions seeker = options.seeker;
  seeker.has_map = is_room(options.map);
  return std::make_unique<Lens>(lens.camera, seeker, lens.covariance, lens.zoom);
}

std::optional<CameraModel> LensesByFrame::serve(const Frame& frame) {
  EXPECTS(options_.new_lenses != nullptr);
  if (std::isnan(frame.zoom)) return std::nullopt;
  const auto zoom = static_cast<int>(std::lround(frame.zoom));
  if (!served_ || served_->zoom != zoom) {
    const std::optional<ZoomLens> lens = zoom_.at(zoom);
    if (!lens) return std::nullopt;
    options_.new_lenses->put(make_lens(*lens, options_));
    served_ = lens;
  }
  return served_->camera;
}

}  // namespace ninedot
