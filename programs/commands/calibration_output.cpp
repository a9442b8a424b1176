#include "programs/commands/calibration_output.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "calibrate_camera/sufficiency.h"
#include "drawing/calibration_picture.h"

namespace ninedot {

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

std::string wish_for_views(const LensCalibration& result) {
  std::vector<std::string> places;
  for (const UncertainPart& part : uncertain_parts(result))
    places.push_back(fmt::format("{} ({:.2g} px)", kPartNames[part.part], part.sigma_px));
  if (places.empty()) return {};
  return fmt::format("least certain: {}; more views with the sheet right in these corners would make them better",
                     fmt::join(places, ", "));
}

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

CalibrationNotes calibration_notes(const LensCalibration& result, const std::string& lens) {
  CalibrationNotes notes;
  notes.date = fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::chrono::system_clock::now()));
  notes.lens = lens;
  notes.views = result.views.size();
  notes.rms_px = result.rms_px;
  notes.direction_sigma_px = result.directions.median_px();
  notes.direction_sigma_max_px = result.directions.max_px();
  notes.covariance = result.covariance.matrix;
  return notes;
}

std::string camera_name_of(const std::string& out) {
  std::string name = out.empty() || out == "-" ? "camera" : std::filesystem::path(out).stem().string();
  for (char& letter : name)  // YAML takes some others for more than a letter
    if (letter >= 0 && std::isalnum(static_cast<unsigned char>(letter)) == 0 && letter != '_' && letter != '-' &&
        letter != '.')
      letter = '_';
  return name;
}

std::string picture_beside(const std::string& out, const std::string& picture) {
  std::error_code error;
  const bool is_device = std::filesystem::exists(out, error) && !std::filesystem::is_regular_file(out, error);
  if (!picture.empty() || out == "-" || is_device) return picture;
  return std::filesystem::path(out).replace_extension(".svg").string();
}

std::string camera_file_of(const LensCalibration& result, const std::string& name, const std::string& lens,
                           bool is_forced) {
  CalibrationNotes notes = calibration_notes(result, lens);
  notes.comments = {
      "Made by `ninedot calibrate camera`, in the form of ROS camera_info: pixels, and pixel centres at "
      "whole numbers.",
      summary_of(result)};
  if (std::string wish = wish_for_views(result); !wish.empty()) notes.comments.push_back(std::move(wish));
  for (const std::string& line : model_lines(result, is_forced)) notes.comments.push_back(line);
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

}  // namespace ninedot
