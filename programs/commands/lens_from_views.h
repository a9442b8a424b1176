#pragma once
/// The work of `ninedot calibrate camera`, and of `calibrate zoom` at each position: from pictures to a lens, or to
/// what they lack.
#include <string>
#include <string_view>
#include <vector>

#include "calibrate_camera/lens_calibration.h"
#include "drivers/posix/signals.h"
#include "programs/commands/calibration_target.h"
#include "programs/commands/collect_views.h"
#include "programs/commands/live_views.h"
#include "programs/commands/progress.h"

namespace ninedot {

/// For recordings: the lens's size, its model if one is asked for, and the recordings' own camera.yaml as one more
/// place to start from, unless it is damaged or for another size. \param model  a name, empty: whichever
LensCalibrationOptions lens_options(const CalibrationPictures& pictures, const std::string& model);

/// plumb_bob, rational_polynomial, equidistant; none: no such model.
std::optional<DistortionModel> model_of(const std::string& name);

/// Shows on a terminal how far it is. The first of the signals ends the looking for views, and those that there are are
/// used; the second ends it all. Threads: one caller.
///
/// Both ways throw StartupError(kWorkFailed), one line: what is missing, or that it was stopped.
class LensFromViews {
 public:
  /// \param lens  size, and perhaps model and guess \param signals  made before the first thread; outlives this
  /// \param news  who is told besides, and ends it all by not listening any more; outlives this; null: nobody
  LensFromViews(CalibrationTarget target, const LensCalibrationOptions& lens, const TerminationSignals& signals,
                CalibrationNews* news = nullptr);

  /// What the first signal does while recordings are searched.
  enum class Interrupted {
    kUsesWhatThereIs,  ///< and says so
    kGivesUp,
  };
  /// Throws also what collect_views throws.
  LensCalibration of_recordings(const CalibrationPictures& pictures, Interrupted interrupted);

  /// Looks until there are enough views for a lens that lacks nothing, or until the source or a signal ends it.
  /// \param keep  as LiveViewsOptions has it
  LensCalibration of_camera(const OpenedSource& source, const std::string& keep);

  /// The same recordings' views in another lens model. \pre of_recordings has found them (contract)
  LensCalibration again_in(DistortionModel model);

  /// A signal has ended the looking for views.
  bool is_stopped() const noexcept { return gathering_stopped_; }
  const CalibrationTarget& target() const noexcept { return target_; }

 private:
  CollectedViews collect(const CalibrationPictures& pictures, const CameraModel& lens);
  void check_views(std::span<const SheetView> views, std::size_t found, std::size_t pictures);
  LensCalibration good_lens();
  LensCalibration calibrate(std::span<const SheetView> views);
  std::optional<CameraModel> rough_lens(std::span<const SheetView> views);
  bool is_gathering_stopped();
  void show(std::string_view what);
  [[noreturn]] void give_up(const std::string& what);
  [[noreturn]] void give_up_for(const std::vector<std::string>& lacks);

  CalibrationTarget target_;
  LensCalibrationOptions options_;
  const TerminationSignals& signals_;
  CalibrationNews* const news_;
  Progress progress_;
  std::vector<SheetView> views_;  ///< of recordings
  bool gathering_stopped_ = false, stopped_ = false;
  bool is_live_ = false;  ///< views of a camera
  std::string kept_;      ///< as LiveViews::where_kept has it
};

}  // namespace ninedot
