// `ninedot calibrate zoom`: the lens of a zoom camera, from a recording at each of some positions of its zoom.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/startup_error.h"
#include "calibrate/zoom_file.h"
#include "drawing/zoom_picture.h"
#include "drivers/posix/output_file.h"
#include "drivers/posix/signals.h"
#include "drivers/recording/recording_index.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/calibrate_commands.h"
#include "programs/commands/calibration_output.h"
#include "programs/commands/calibration_target.h"
#include "programs/commands/lens_from_views.h"
#include "programs/commands/output_check.h"

namespace ninedot {
namespace {

constexpr int kMaxZoom = 0xFFFF;  // what VISCA can say

struct CalibrateZoomArguments {
  std::vector<std::string> at;
  SheetArguments sheet;
  std::string out, picture, lens;
};

[[noreturn]] void give_up(const std::string& what) { throw StartupError(ExitStatus::kWorkFailed, what); }

struct RecordedZoom {
  int zoom = 0;  // [steps]
  std::string recording;
};

RecordedZoom recorded_zoom(const std::string& text) {
  RecordedZoom at;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), at.zoom);
  const auto used = static_cast<std::size_t>(end - text.data());
  if (error != std::errc{} || at.zoom < 0 || at.zoom > kMaxZoom || used + 1 >= text.size() || text[used] != ':')
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("--at {}: give ZOOM:RECORDING, the position from 0 to {} and a folder or .y4m file",
                                   text, kMaxZoom));
  at.recording = text.substr(used + 1);
  return at;
}

/// What the recording itself says of its zoom, where it does.
void check_zoom_of_frames(const RecordedZoom& at) {
  for (const RecordedFrame& frame : read_recording_index(at.recording).frames)
    if (frame.zoom.value_or(at.zoom) != at.zoom)
      throw StartupError(ExitStatus::kWrongUsage,
                         fmt::format("{}: frame {} was taken at zoom {}, not {}: each recording is of one position",
                                     at.recording, frame.number, *frame.zoom, at.zoom));
}

/// By rising position.
std::vector<RecordedZoom> recorded_zooms(const std::vector<std::string>& texts) {
  std::vector<RecordedZoom> all;
  for (const std::string& text : texts) all.push_back(recorded_zoom(text));
  std::ranges::stable_sort(all, {}, &RecordedZoom::zoom);
  if (all.size() < 2)
    throw StartupError(ExitStatus::kWrongUsage,
                       "one position makes no zoom: give --at twice or more, or take "
                       "`ninedot calibrate camera` for a zoom that is locked");
  if (all.size() > kMostZooms)
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("{} positions are too many: give {} at most", all.size(), kMostZooms));
  if (const auto same = std::ranges::adjacent_find(all, {}, &RecordedZoom::zoom); same != all.end())
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("position {} is there twice: give each position one --at", same->zoom));
  return all;
}

/// The calibrations of all positions, each from its own recording.
class ZoomCalibration {
 public:
  explicit ZoomCalibration(const CalibrateZoomArguments& arguments) : positions_(recorded_zooms(arguments.at)) {
    if (!arguments.sheet.grid.empty() && !arguments.sheet.config.empty())
      throw StartupError(ExitStatus::kWrongUsage, "a grid needs no --config: leave it out");
    const std::optional<Config> config =
        arguments.sheet.config.empty() ? std::nullopt : std::optional(read_config(arguments.sheet.config));
    const CalibrationTarget target = target_of(arguments.sheet, config);
    for (const RecordedZoom& at : positions_) {
      const CalibrationPictures& pictures = pictures_.emplace_back(check_recordings({at.recording}));
      works_.push_back(
          std::make_unique<LensFromViews>(target, lens_options(pictures, arguments.sheet.model), signals_));
      check_zoom_of_frames(at);
      const PictureSize size = pictures.size, first = pictures_.front().size;
      if (size != first)
        throw StartupError(
            ExitStatus::kWrongUsage,
            fmt::format("{}: its pictures are {}x{}, those of {} {}x{}: all of one size", at.recording, size.width_px,
                        size.height_px, positions_.front().recording, first.width_px, first.height_px));
    }
  }

  void run() {
    for (std::size_t i = 0; i < positions_.size(); ++i)
      calibrations_.push_back(
          named(i, [&] { return works_[i]->of_recordings(pictures_[i], LensFromViews::Interrupted::kGivesUp); }));
    const DistortionModel model = common_model();
    for (std::size_t i = 0; i < positions_.size(); ++i)
      if (calibrations_[i].fit.camera.model != model)
        calibrations_[i] = named(i, [&] { return works_[i]->again_in(model); });
  }

  std::vector<ZoomLens> lenses() const {
    std::vector<ZoomLens> lenses;
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      ZoomLens& lens = lenses.emplace_back();
      lens.zoom = positions_[i].zoom;
      lens.camera = calibrations_[i].fit.camera;
      const Eigen::MatrixXd& covariance = calibrations_[i].covariance.matrix;
      lens.covariance.topLeftCorner(covariance.rows(), covariance.cols()) = covariance;
    }
    return lenses;
  }

  const std::vector<LensCalibration>& calibrations() const { return calibrations_; }

 private:
  /// With the recording that does not suffice.
  template <typename Work>
  LensCalibration named(std::size_t i, Work work) {
    try {
      LensCalibration result = work();
      if (works_[i]->is_stopped()) give_up("stopped: nothing was written");
      return result;
    } catch (const StartupError& error) {
      throw StartupError(error.status,
                         fmt::format("zoom {}, {}: {}", positions_[i].zoom, positions_[i].recording, error.what()));
    }
  }

  /// Of those that a position asks for, the one that foretells the unseen views of all positions best.
  DistortionModel common_model() const {
    const auto squares_of = [&](DistortionModel model) {
      double squares_px2 = 0;
      for (const LensCalibration& calibration : calibrations_)
        for (const TriedModel& tried : calibration.tried)
          if (tried.model == model) squares_px2 += tried.held_out_px * tried.held_out_px;
      return squares_px2;
    };
    DistortionModel best = calibrations_.front().fit.camera.model;
    for (const LensCalibration& calibration : calibrations_)
      if (squares_of(calibration.fit.camera.model) < squares_of(best)) best = calibration.fit.camera.model;
    return best;
  }

  const TerminationSignals signals_;  // before the first thread
  const std::vector<RecordedZoom> positions_;
  std::vector<CalibrationPictures> pictures_;  // of each position
  std::vector<std::unique_ptr<LensFromViews>> works_;
  std::vector<LensCalibration> calibrations_;
};

/// Refuses positions that make no table, or one that does not know the focal length between them.
ZoomTable zoom_table(std::vector<ZoomLens> lenses) {
  if (const auto lack = what_zooms_lack(lenses)) give_up(*lack);
  ZoomTable table(std::move(lenses));
  if (const auto lack = what_gaps_lack(table)) give_up(*lack);
  return table;
}

/// What is said of it, on the terminal and at the file's beginning.
std::vector<std::string> lines_of(const ZoomTable& table, const std::vector<LensCalibration>& calibrations) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < calibrations.size(); ++i)
    lines.push_back(fmt::format("zoom {}: {}", table.lenses()[i].zoom, summary_of(calibrations[i])));
  if (!table.knows_between()) {
    lines.push_back(
        fmt::format("{} positions: the lens is known at them alone; with {} and more it is known between them too",
                    table.lenses().size(), ZoomTable::kLeastForBetween));
    return lines;
  }
  for (const HeldOutZoom& held_out : table.held_out()) {
    const CameraModel& own = std::ranges::find(table.lenses(), held_out.zoom, &ZoomLens::zoom)->camera;
    lines.push_back(fmt::format(
        "zoom {} as the others foretell it: focal length off by {:.2g} %, directions by {:.2g} px", held_out.zoom,
        100 * (held_out.foretold.fx_px / own.fx_px - 1), direction_differences(own, held_out.foretold).median_px()));
  }
  const ZoomGap gap = table.worst_gap();
  lines.push_back(fmt::format("known from {}: focal length to {:.2g} % at worst, between {} and {}", table.reach(),
                              100 * gap.focal_sigma, gap.from, gap.to));
  return lines;
}

std::string file_of(const ZoomTable& table, const std::vector<LensCalibration>& calibrations,
                    const std::vector<std::string>& lines, const CalibrateZoomArguments& arguments) {
  const auto widest = static_cast<std::size_t>(&table.widest() - table.lenses().data());
  CalibrationNotes notes = calibration_notes(calibrations[widest], arguments.lens);
  notes.comments = {
      fmt::format("Made by `ninedot calibrate zoom`, in the form of ROS camera_info, which knows no zoom: "
                  "what it says is the lens at {}, the widest; all positions stand at the end.",
                  table.widest().zoom)};
  notes.comments.insert(notes.comments.end(), lines.begin(), lines.end());
  return format_calibrated_camera(table.widest().camera, camera_name_of(arguments.out), notes) + format_zoom(table);
}

DrawnZoom drawn(const ZoomLens& lens) { return {lens.zoom, lens.camera.fx_px, lens.camera.cx_px, lens.camera.cy_px}; }

std::string picture_of(const ZoomTable& table, const std::string& title) {
  constexpr int kPoints = 100;
  ZoomDrawing drawing{{}, {}, title};
  for (const ZoomLens& lens : table.lenses()) drawing.calibrated.push_back(drawn(lens));
  const int first = table.lenses().front().zoom, last = table.lenses().back().zoom;
  for (int i = 0; table.knows_between() && i <= kPoints; ++i)
    drawing.between.push_back(drawn(*table.at(first + (last - first) * i / kPoints)));
  return draw_zoom(drawing);
}

void check_zoom_outputs(const CalibrateZoomArguments& arguments) {
  check_named({"--out", arguments.out});
  std::vector<std::string> inputs{arguments.sheet.config};
  for (const std::string& text : arguments.at) inputs.push_back(recorded_zoom(text).recording);
  check_outputs({{"--out", arguments.out}, {"--picture", picture_beside(arguments.out, arguments.picture)}}, inputs);
}

void run_calibrate_zoom(const CalibrateZoomArguments& arguments) {
  check_zoom_outputs(arguments);
  ZoomCalibration calibration(arguments);
  // Before the work, so that a folder that is not there is told at once.
  OutputFile file(arguments.out);
  const std::string picture = picture_beside(arguments.out, arguments.picture);
  std::optional<OutputFile> picture_file;
  if (!picture.empty()) picture_file.emplace(picture);

  calibration.run();
  const ZoomTable table = zoom_table(calibration.lenses());
  const std::vector<std::string> lines = lines_of(table, calibration.calibrations());
  if (picture_file) picture_file->write(picture_of(table, lines.back()));
  file.write(file_of(table, calibration.calibrations(), lines, arguments));
  finish_together({picture_file ? &*picture_file : nullptr, &file});
  for (const std::string& line : lines) fmt::print(stderr, "{}\n", line);
}

}  // namespace

void add_calibrate_zoom_command(CLI::App& group) {
  CLI::App* command = group.add_subcommand(
      "zoom", "The lens of a zoom camera over its positions, from a recording of a landmark at each of some");
  const auto arguments = std::make_shared<CalibrateZoomArguments>();
  command
      ->add_option("--at", arguments->at,
                   "ZOOM:RECORDING, once for each position: where the zoom stood, as the camera counts, and what was "
                   "recorded there; with five and more the lens is known between them too")
      ->required()
      ->take_all();
  command->add_option("--config", arguments->sheet.config,
                      "whose [landmark] says how large the sheet is; default: 80 mm");
  add_sheet_options(*command, arguments->sheet);
  command->add_option("--lens", arguments->lens, "what to call the lens in the file");
  command->add_option("--out", arguments->out, "file for the calibration, which camera.calibration may name")
      ->required();
  command->add_option("--picture", arguments->picture,
                      "SVG file: focal length and centre over the zoom; default: beside --out");
  command->callback([arguments] { run_calibrate_zoom(*arguments); });
}

}  // namespace ninedot
