#include "programs/commands/lens_from_views.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <utility>

#include "base/contract.h"
#include "base/startup_error.h"
#include "calibrate/camera_file.h"
#include "calibrate_camera/sufficiency.h"
#include "drivers/recording/recording_index.h"
#include "programs/assembly/input_files.h"

namespace ninedot {

using namespace std::chrono_literals;

namespace {

/// Twice as many as a good calibration has: patience ends before the last corner is as certain as the middle.
constexpr std::size_t kMostViews = 60;

std::optional<CameraModel> guess_of(const CalibrationPictures& pictures) {
  for (const std::string& recording : pictures.recordings) {
    try {
      const CameraModel camera = read_camera_file(recording_camera_file(recording));
      if (PictureSize{camera.width_px, camera.height_px} == pictures.size) return camera;
    } catch (const StartupError&) {
      continue;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<DistortionModel> model_of(const std::string& name) {
  for (const DistortionModel model :
       {DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial, DistortionModel::kEquidistant})
    if (name == name_of(model)) return model;
  return std::nullopt;
}

LensCalibrationOptions lens_options(const CalibrationPictures& pictures, const std::string& model) {
  LensCalibrationOptions lens;
  lens.width_px = pictures.size.width_px, lens.height_px = pictures.size.height_px;
  lens.model = model_of(model);
  lens.guess = guess_of(pictures);
  return lens;
}

LensFromViews::LensFromViews(CalibrationTarget target, const LensCalibrationOptions& lens,
                             const TerminationSignals& signals, CalibrationNews* news)
    : target_(std::move(target)), options_(lens), signals_(signals), news_(news) {
  options_.go_on = [this](std::string_view what) {
    show(what);
    if (news_ != nullptr && news_->is_broken()) stopped_ = true;
    if (signals_.wait(0ns) != 0) {
      // Of a camera's views this may be one lens of several: the first signal ends the gathering then too.
      stopped_ = gathering_stopped_ || !is_live_;
      gathering_stopped_ = true;
    }
    return !stopped_;
  };
}

LensCalibration LensFromViews::of_recordings(const CalibrationPictures& pictures, Interrupted interrupted) {
  CollectedViews collected = collect(pictures, usual_camera(options_.width_px, options_.height_px));
  // A lens that bends much hides the landmark from a search that knows nothing of it: once more, with what is known.
  if (!target_.grid && !gathering_stopped_ && collected.views.found() < collected.pictures) {
    if (const std::optional<CameraModel> lens = rough_lens(collected.views.views())) {
      CollectedViews again = collect(pictures, *lens);
      if (again.views.found() > collected.views.found()) collected = std::move(again);
    }
  }
  if (gathering_stopped_ && interrupted == Interrupted::kGivesUp) give_up("stopped: nothing was written");
  check_views(collected.views.views(), collected.views.found(), collected.pictures);
  progress_.clear();
  if (gathering_stopped_)
    fmt::print(stderr, "ninedot: interrupted: what follows is of the first {} pictures\n", collected.pictures);
  views_ = collected.views.views();
  return good_lens();
}

LensCalibration LensFromViews::again_in(DistortionModel model) {
  EXPECTS(!views_.empty());
  options_.model = model;
  return good_lens();
}

LensCalibration LensFromViews::good_lens() {
  LensCalibration result = calibrate(views_);
  if (const std::vector<std::string> lacks = what_lens_lacks(result); !lacks.empty()) give_up_for(lacks);
  progress_.clear();
  return result;
}

LensCalibration LensFromViews::of_camera(const OpenedSource& source, const std::string& keep) {
  is_live_ = true;
  LiveViewsOptions how{options_.width_px,
                       options_.height_px,
                       keep,
                       [this] { return is_gathering_stopped(); },
                       [this](std::span<const SheetView> views) { return rough_lens(views); },
                       news_};
  LiveViews live(source, target_, std::move(how));
  for (;;) {
    const LiveViews::End end = live.gather();
    kept_ = live.where_kept();
    check_views(live.views().views(), live.views().found(), live.pictures());
    LensCalibration result = calibrate(live.views().views());
    progress_.clear();
    std::vector<std::string> lacks = what_lens_lacks(result);
    const std::vector<UncertainPart> uncertain = uncertain_parts(result);
    const bool may_go_on = end == LiveViews::End::kEnough && !gathering_stopped_;
    const bool is_good = uncertain.empty() || live.views().views().size() >= kMostViews;
    if (lacks.empty() && (is_good || !may_go_on)) return result;
    if (!may_go_on) give_up_for(lacks);
    live.want_more(result.fit.camera, std::move(lacks), uncertain);
  }
}

CollectedViews LensFromViews::collect(const CalibrationPictures& pictures, const CameraModel& lens) {
  return collect_views(pictures, *target_.finder(lens), target_.discs, [this](const std::string& what) {
    progress_.show(what + ", Ctrl-C ends the search");
    return !is_gathering_stopped();
  });
}

void LensFromViews::check_views(std::span<const SheetView> views, std::size_t found, std::size_t pictures) {
  if (found == 0 && gathering_stopped_) give_up("stopped before the first view: nothing was written");
  if (found == 0)
    give_up(fmt::format("no {} in any of {} pictures: is it the right sheet, near enough and whole in the picture?",
                        target_.name(), pictures));
  std::vector<std::string> lacks = what_views_lack(views, found, options_.width_px, options_.height_px);
  if (!lacks.empty() && !is_live_ && 2 * found < pictures)
    lacks.push_back(
        fmt::format("the {} was recognised in {} of {} pictures: one sheet alone, whole, flat and evenly lit",
                    target_.name(), found, pictures));
  if (!lacks.empty()) give_up_for(lacks);
}

LensCalibration LensFromViews::calibrate(std::span<const SheetView> views) {
  if (auto result = calibrate_lens(target_.discs, {views.begin(), views.end()}, options_)) return std::move(*result);
  if (stopped_) give_up("stopped: nothing was written");
  give_up("no lens explains the views: tilt the sheet by 30 to 45 degrees in a part of them, to all sides");
}

std::optional<CameraModel> LensFromViews::rough_lens(std::span<const SheetView> views) {
  LensCalibrationOptions rough = options_;
  rough.rough = true;
  rough.go_on = [this](std::string_view what) {
    show(what);
    return !is_gathering_stopped();
  };
  const auto lens = calibrate_lens(target_.discs, {views.begin(), views.end()}, rough);
  return lens ? std::optional(lens->fit.camera) : std::nullopt;
}

void LensFromViews::show(std::string_view what) {
  progress_.show(what);
  if (news_ != nullptr) news_->working(what);
}

bool LensFromViews::is_gathering_stopped() {
  if (news_ != nullptr && news_->is_broken()) gathering_stopped_ = stopped_ = true;
  gathering_stopped_ = gathering_stopped_ || signals_.wait(0ns) != 0;
  return gathering_stopped_;
}

void LensFromViews::give_up(const std::string& what) {
  progress_.clear();
  throw StartupError(ExitStatus::kWorkFailed, what + kept_);
}

void LensFromViews::give_up_for(const std::vector<std::string>& lacks) {
  give_up(fmt::format("{}{}", gathering_stopped_ ? "stopped too early: " : "", fmt::join(lacks, "; ")));
}

}  // namespace ninedot
