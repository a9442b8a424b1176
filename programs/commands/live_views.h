#pragma once
/// Views of a calibration's sheet from a camera, while somebody moves the sheet and is told what is missing.
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/mono_time.h"
#include "calibrate_camera/view_gatherer.h"
#include "drivers/recording/recording_writer.h"
#include "programs/assembly/open_source.h"
#include "programs/commands/calibration_news.h"
#include "programs/commands/calibration_target.h"
#include "programs/commands/gathering_view.h"
#include "programs/display/redrawn_lines.h"

namespace ninedot {

struct LiveViewsOptions {
  int width_px = 0, height_px = 0;  ///< of the camera's pictures
  std::string keep;                 ///< a new folder, for a recording of the views' pictures; empty: none
  /// Asked before each picture; true ends the gathering.
  std::function<bool()> is_stopped;
  /// A lens from the views so far, to search with; nothing: none fits. A lens that bends much hides the sheet from a
  /// search that knows nothing of it, in the corners first.
  std::function<std::optional<CameraModel>(std::span<const SheetView>)> rough_lens;
  CalibrationNews* news = nullptr;  ///< who is told besides, and shown how to hold the sheet; null: nobody
};

/// On a terminal standard error shows what is wanted, in place; in a pipe it gets a line for each view.
/// Memory: as ViewGatherer. Threads: one caller.
class LiveViews {
 public:
  enum class End {
    kEnough,       ///< nothing is wanted any more
    kStopped,      ///< by options.is_stopped
    kSourceEnded,  ///< a recording, or a simulation, in the camera's place
  };

  /// \param source, target  outlive this
  /// Throws StartupError as RecordingWriter does.
  LiveViews(const OpenedSource& source, const CalibrationTarget& target, LiveViewsOptions options);

  /// Throws StartupError(kWorkFailed): the camera is gone, or a view can't be written.
  End gather();

  /// There are enough views but for what the lens that was made of them says: the next `gather` takes as many more as
  /// may mend it. \param lens  that was made \param lens_lacks  as what_lens_lacks has it
  void want_more(const CameraModel& lens, std::vector<std::string> lens_lacks,
                 std::span<const UncertainPart> uncertain);

  const ViewGatherer& views() const noexcept { return gatherer_; }
  std::size_t pictures() const noexcept { return pictures_; }  ///< how many were looked at
  /// "; the 12 views are kept in FOLDER", or nothing where none are.
  std::string where_kept() const;

 private:
  void look_at(FrameLease& lease);
  void keep(FrameLease& lease);
  void learn_lens();
  void tell(Looked looked);
  void tell_news(const GatheringState& now);
  SheetGhost ghost_for(std::span<const Want> wanted) const;
  ViewTally tally() const;

  const OpenedSource& source_;
  const CalibrationTarget& target_;
  LiveViewsOptions options_;
  std::unique_ptr<SheetFinder> finder_;
  ViewGatherer gatherer_;
  std::optional<RecordingWriter> writer_;
  RedrawnLines lines_;
  MonoTime shown_at_{};
  ViewGoals goals_;
  std::vector<Want> wanted_;
  std::vector<std::string> lens_lacks_;
  CameraModel lens_;  // as far as it is known
  SheetGhost ghost_;
  std::size_t pictures_ = 0, lens_of_ = 0;
};

}  // namespace ninedot
