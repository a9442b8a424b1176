// `ninedot calibrate camera`: a lens from recordings of a landmark, or of a printed grid of dots.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/startup_error.h"
#include "calibrate/camera_file_text.h"
#include "calibrate_camera/grid_finder.h"
#include "calibrate_camera/lens_calibration.h"
#include "calibrate_camera/sufficiency.h"
#include "drawing/calibration_picture.h"
#include "drivers/posix/output_file.h"
#include "drivers/posix/signals.h"
#include "drivers/recording/recording_index.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/commands/calibrate_commands.h"
#include "programs/commands/collect_views.h"
#include "programs/commands/dot_grid_option.h"
#include "programs/commands/progress.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct CalibrateCameraArguments {
  std::vector<std::string> recordings;
  std::string config, grid, out, picture, model, lens;
};

[[noreturn]] void give_up(const std::string& what) { throw StartupError(ExitStatus::kWorkFailed, what); }

/// The sheet: where its discs are, and who finds it.
struct Target {
  LandmarkGeometry landmark;
  std::optional<DotGrid> grid;
  std::vector<PlaneDisc> discs;

  std::string name() const { return grid ? fmt::format("grid of {}x{} dots", grid->columns, grid->rows) : "landmark"; }
  std::unique_ptr<SheetFinder> finder(const CameraModel& guess) const {
    if (grid) return std::make_unique<GridFinder>(guess.width_px, guess.height_px, *grid);
    return std::make_unique<LandmarkFinder>(guess, landmark);
  }
};

Target target_of(const CalibrateCameraArguments& arguments) {
  Target target;
  if (!arguments.grid.empty()) {
    target.grid = read_dot_grid(arguments.grid);
    target.discs = discs_of(*target.grid);
    return target;
  }
  if (!arguments.config.empty()) target.landmark = localiser_options(read_config(arguments.config)).seeker.landmark;
  target.discs = discs_of(target.landmark);
  return target;
}

std::optional<DistortionModel> model_of(const std::string& name) {
  for (const DistortionModel model :
       {DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial, DistortionModel::kEquidistant})
    if (name == name_of(model)) return model;
  return std::nullopt;
}

/// A recording's own camera.yaml is one more place to start from; one that is damaged, or for another size, is none.
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

/// The work, with what a terminal shows of it and what Ctrl-C does.
class CameraCalibration {
 public:
  explicit CameraCalibration(const CalibrateCameraArguments& arguments)
      : target_(target_of(arguments)), pictures_(check_recordings(arguments.recordings)) {
    options_.width_px = pictures_.size.width_px, options_.height_px = pictures_.size.height_px;
    options_.model = model_of(arguments.model);
    options_.guess = guess_of(pictures_);
    options_.go_on = [this](std::string_view what) {
      progress_.show(what);
      return signals_.wait(0ns) == 0;
    };
  }

  LensCalibration run() {
    CollectedViews collected = collect(usual_camera(options_.width_px, options_.height_px));
    // A lens that bends much hides the landmark from a search that knows nothing of it: once more, with what is known.
    if (!target_.grid && !gathering_stopped_ && collected.views.found() < collected.pictures) {
      LensCalibrationOptions rough = options_;
      rough.rough = true;
      if (const auto lens = calibrate_lens(target_.discs, collected.views.views(), rough)) {
        CollectedViews again = collect(lens->fit.camera);
        if (again.views.found() > collected.views.found()) collected = std::move(again);
      }
    }
    check(collected);
    LensCalibration result = calibrate(collected);
    const std::vector<std::string> lacks = what_lens_lacks(result);
    progress_.clear();
    if (!lacks.empty()) give_up(in_one_line(lacks));
    return result;
  }

  std::span<const PlaneDisc> discs() const { return target_.discs; }

 private:
  CollectedViews collect(const CameraModel& lens) {
    return collect_views(pictures_, *target_.finder(lens), target_.discs, [this](const std::string& what) {
      progress_.show(what + ", Ctrl-C ends the search");
      gathering_stopped_ = gathering_stopped_ || signals_.wait(0ns) != 0;
      return !gathering_stopped_;
    });
  }

  void check(const CollectedViews& collected) {
    if (collected.views.found() == 0) {
      progress_.clear();
      if (gathering_stopped_) give_up("stopped before the first view: nothing was written");
      give_up(fmt::format("no {} in any of {} pictures: is it the right sheet, near enough and whole in the picture?",
                          target_.name(), collected.pictures));
    }
    const std::vector<std::string> lacks =
        what_views_lack(collected.views.views(), collected.views.found(), options_.width_px, options_.height_px);
    if (lacks.empty()) return;
    progress_.clear();
    give_up(in_one_line(lacks));
  }

  LensCalibration calibrate(const CollectedViews& collected) {
    std::optional<LensCalibration> result = calibrate_lens(target_.discs, collected.views.views(), options_);
    if (result) return std::move(*result);
    progress_.clear();
    if (!options_.go_on("")) give_up("stopped: nothing was written");
    give_up("no lens explains the views: tilt the sheet by 30 to 45 degrees in a part of them, to all sides");
  }

  std::string in_one_line(const std::vector<std::string>& lacks) const {
    return fmt::format("{}{}", gathering_stopped_ ? "stopped too early: " : "", fmt::join(lacks, "; "));
  }

  const TerminationSignals signals_;  // before the first thread
  Target target_;
  CalibrationPictures pictures_;
  LensCalibrationOptions options_;
  Progress progress_;
  bool gathering_stopped_ = false;
};

/// "plumb_bob, fx 612.31 +- 0.05 px, ..."
std::string summary_of(const LensCalibration& result) {
  const CameraModel& camera = result.fit.camera;
  const Eigen::VectorXd sigmas = result.covariance.matrix.diagonal().cwiseSqrt();
  return fmt::format(
      "{}: fx {:.2f} +- {:.2g}, fy {:.2f} +- {:.2g}, centre {:.2f} +- {:.2g}, {:.2f} +- {:.2g} px; directions to "
      "{:.2g} "
      "px, {:.2g} px at worst; {} views, outlines off by {:.2g} px",
      name_of(camera.model), camera.fx_px, sigmas(0), camera.fy_px, sigmas(1), camera.cx_px, sigmas(2), camera.cy_px,
      sigmas(3), result.directions.median_px(), result.directions.max_px(), result.views.size(), result.rms_px);
}

/// What became of the lens models.
std::vector<std::string> model_lines(const LensCalibration& result, bool is_forced) {
  if (is_forced) return {fmt::format("{}, as --model asks", name_of(result.fit.camera.model))};
  std::vector<std::string> lines;
  for (const TriedModel& tried : result.tried)
    lines.push_back(std::isfinite(tried.held_out_px)
                        ? fmt::format("{}: {:.4f} px rms in views that it was not fitted to", name_of(tried.model),
                                      tried.held_out_px)
                        : fmt::format("{}: fits the views nowhere", name_of(tried.model)));
  lines.push_back(fmt::format("{} is the simplest that the views support", name_of(result.fit.camera.model)));
  return lines;
}

std::string camera_file_of(const LensCalibration& result, const CalibrateCameraArguments& arguments) {
  CalibrationNotes notes;
  notes.date = fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::chrono::system_clock::now()));
  notes.lens = arguments.lens;
  notes.views = result.views.size();
  notes.rms_px = result.rms_px;
  notes.direction_sigma_px = result.directions.median_px();
  notes.direction_sigma_max_px = result.directions.max_px();
  notes.covariance = result.covariance.matrix;
  notes.comments = {
      "Made by `ninedot calibrate camera`, in the form of ROS camera_info: pixels, and pixel centres at "
      "whole numbers.",
      summary_of(result)};
  for (const std::string& line : model_lines(result, !arguments.model.empty())) notes.comments.push_back(line);
  const std::string name =
      arguments.out.empty() || arguments.out == "-" ? "camera" : std::filesystem::path(arguments.out).stem().string();
  return format_calibrated_camera(result.fit.camera, name, notes);
}

std::string picture_of(const LensCalibration& result, std::span<const PlaneDisc> discs) {
  CalibrationDrawing drawing{
      result.fit.camera.width_px,
      result.fit.camera.height_px,
      {},
      {},
      DirectionErrors::kColumns,
      DirectionErrors::kRows,
      result.directions.sigma_px,
      fmt::format("{}, {} views: directions known to {:.2g} px, {:.2g} px at worst", name_of(result.fit.camera.model),
                  result.views.size(), result.directions.median_px(), result.directions.max_px())};
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    const SheetView& view = result.views[i];
    drawing.disc_centres.emplace_back();
    for (const SeenDisc& seen : view.seen) drawing.disc_centres.back().push_back(seen.centre_px);
    const std::vector<double> off_px = edge_residuals_px(result.fit.camera, discs, view, result.fit.views[i]);
    for (std::size_t e = 0; e < off_px.size(); ++e)
      if (std::abs(off_px[e]) < 5 * total_sigma_px(view.edges[e], result.fit.floor_px))
        drawing.residuals.push_back({view.edges[e].at_px, off_px[e]});
  }
  return draw_calibration(drawing);
}

std::string picture_beside(const CalibrateCameraArguments& arguments) {
  if (!arguments.picture.empty() || arguments.out == "-") return arguments.picture;
  return std::filesystem::path(arguments.out).replace_extension(".svg").string();
}

void run_calibrate_camera(const CalibrateCameraArguments& arguments) {
  CameraCalibration calibration(arguments);
  // Before the work, so that a folder that is not there is told at once.
  OutputFile camera_file(arguments.out);
  const std::string picture = picture_beside(arguments);
  std::optional<OutputFile> picture_file;
  if (!picture.empty()) picture_file.emplace(picture);

  const LensCalibration result = calibration.run();
  if (picture_file) {
    picture_file->write(picture_of(result, calibration.discs()));
    picture_file->finish();
  }
  camera_file.write(camera_file_of(result, arguments));
  camera_file.finish();
  for (const std::string& line : model_lines(result, !arguments.model.empty())) fmt::print(stderr, "{}\n", line);
  if (result.left_out > 0)
    fmt::print(stderr, "{} {} left out: no outline there, or other than the rest has it\n", result.left_out,
               result.left_out == 1 ? "view was" : "views were");
  fmt::print(stderr, "{}\n", summary_of(result));
}

}  // namespace

void add_calibrate_camera_command(CLI::App& group) {
  CLI::App* command = group.add_subcommand(
      "camera", "Focal lengths, centre and distortion, from recordings of a landmark from many sides");
  const auto arguments = std::make_shared<CalibrateCameraArguments>();
  command->add_option("RECORDING", arguments->recordings, "folders with frames/, or .y4m files")->required();
  command->add_option("--config", arguments->config, "whose [landmark] says how large the sheet is; default: 80 mm");
  command
      ->add_option("--grid", arguments->grid,
                   "COLUMNSxROWS@PITCH in mm: a printed grid of dots in place of a landmark (`ninedot pattern --grid`)")
      ->excludes("--config");
  command->add_option("--model", arguments->model, "lens model; default: the simplest that foretells views well")
      ->check(CLI::IsMember({"plumb_bob", "rational_polynomial", "equidistant"}));
  command->add_option("--lens", arguments->lens, "what to call the lens in the file");
  command->add_option("--out", arguments->out, "file for the calibration, which camera.calibration may name")
      ->required();
  command->add_option("--picture", arguments->picture,
                      "SVG file: coverage, residuals and errors of directions; default: beside --out");
  command->callback([arguments] { run_calibrate_camera(*arguments); });
}

}  // namespace ninedot
