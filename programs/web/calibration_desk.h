#pragma once
/// The wizards of `ninedot calibrate camera --tap` and `calibrate pan-tilt --tap` for the page.
#include <string>
#include <string_view>

#include "config/config.h"
#include "programs/web/apply_request.h"
#include "programs/web/child_job.h"

namespace ninedot {

struct CalibrationDeskOptions {
  std::string why_not;      ///< for people: why nothing is calibrated from here; empty: it may be
  std::string config_path;  ///< the service's
  std::string calibration;  ///< that it names; empty: none
  std::string folder;       ///< in which calibrations lie, each in a folder of its own
  bool has_token = false;   ///< of the page
  std::string no_head;      ///< as why_not, of the head alone
  std::string limits;       ///< of the head, for the page: {"pan":{"min":-45,"max":45},"tilt":...} [deg]
};

/// \param has_token  without one nothing is begun
CalibrationDeskOptions calibration_desk_options(const Config& config, const std::string& config_path, bool has_token);

/// Memory, threads: as ChildJob.
class CalibrationDesk {
 public:
  /// \param job  at which calibrations are made \param request  both must outlive this
  CalibrationDesk(CalibrationDeskOptions options, ChildJob& job, ApplyRequest& request)
      : options_(std::move(options)), job_(job), request_(request) {}

  /// \param text  "start camera", "start pan-tilt", "finish": go on with what there is by now, "cancel", or "use
  /// NAME": that one is to take the place of the service's; not a character more
  /// \return  its status also: 400 not understood, 409 not now, 500 it could not be begun
  DeskReply reply_to(std::string_view text);
  /// What there is, for a page that is shown. \see docs/calibrating.md for the lines of the child in it
  std::string state_json() const;
  /// \param path  what follows /api/calibrate/ : NAME/camera.yaml, NAME/camera.svg or NAME/head.toml, to
  /// the last character
  /// \return  where it lies; empty: it is none of these
  std::string file_of(std::string_view path) const;

 private:
  DeskReply start(bool of_head);
  DeskReply use(std::string_view name);
  DeskReply with_state(const DeskReply& reply) const;

  const CalibrationDeskOptions options_;
  ChildJob& job_;
  ApplyRequest& request_;
};

}  // namespace ninedot
