// `ninedot calibrate ellipse`: the founding paper's constants, from shots at known distances.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/startup_error.h"
#include "base/units.h"
#include "calibrate/ellipse_fit.h"
#include "drivers/posix/output_file.h"
#include "drivers/posix/text_file.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/calibrate_commands.h"
#include "programs/commands/output_check.h"
#include "programs/commands/recording_frames.h"

namespace ninedot {
namespace {

struct EllipseArguments {
  std::string recording, config, camera, shots_file, out;
  std::vector<std::string> shots;
  double focal_length_mm = 0;
};

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

template <typename T>
bool read_number(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

/// "3,1500" or "4,1500,3". \param where  for errors
EllipseShot shot_of(std::string_view text, char separator, const std::string& where) {
  constexpr double kFarthest_mm = 1e6;
  std::vector<std::string_view> fields;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find(separator, at);
    fields.push_back(text.substr(at, end - at));
    if (end == std::string_view::npos) break;
    at = end + 1;
  }
  EllipseShot shot;
  double distance_mm = 0;
  const bool is_shot = (fields.size() == 2 || fields.size() == 3) && read_number(fields[0], shot.frame) &&
                       read_number(fields[1], distance_mm) && distance_mm > 0 && distance_mm < kFarthest_mm;
  std::uint64_t centred = 0;
  const bool is_off_centre = fields.size() == 3 && !fields[2].empty();
  if (!is_shot || (is_off_centre && !read_number(fields[2], centred)))
    refuse(
        fmt::format("{}: write a frame's number, its distance in mm, and of an off-centre shot the number of its "
                    "centred one",
                    where));
  shot.distance_m = distance_mm * kMetresPerMm;
  if (is_off_centre) shot.centred_frame = centred;
  return shot;
}

std::vector<EllipseShot> read_shots(const EllipseArguments& arguments) {
  std::vector<EllipseShot> shots;
  for (const std::string& text : arguments.shots) shots.push_back(shot_of(text, ':', "--shot " + text));
  if (!arguments.shots_file.empty()) {
    const std::string text = read_text_file(arguments.shots_file, kMaxFile_bytes);
    int line = 0;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      std::string_view row = std::string_view(text).substr(at, end - at);
      if (row.ends_with('\r')) row.remove_suffix(1);
      at = end + 1;
      const bool is_header = ++line == 1 && row.starts_with("frame");
      if (!row.empty() && !is_header)
        shots.push_back(shot_of(row, ',', fmt::format("{}:{}", arguments.shots_file, line)));
    }
  }
  if (shots.empty()) refuse("no shots: give them with --shots FILE.csv (frame,distance_mm,centred_frame) or --shot");
  std::ranges::sort(shots, {}, &EllipseShot::frame);
  const auto twice = std::ranges::adjacent_find(shots, {}, &EllipseShot::frame);
  if (twice != shots.end()) refuse(fmt::format("frame {} is there twice", twice->frame));
  return shots;
}

/// Looks at the pictures and fills in what they show.
void see(std::vector<EllipseShot>& shots, const EllipseArguments& arguments, const Config& config,
         const RecordingView& view) {
  std::map<std::uint64_t, bool> seen_in;
  const SeenFrames looked = look_at_frames(
      arguments.recording, config, view, false, [&](const Frame& frame, const Fix&, const LandmarkObservation* seen) {
        const auto shot = std::ranges::find(shots, frame.number, &EllipseShot::frame);
        if (shot == shots.end()) return;
        seen_in[frame.number] = false;
        if (seen == nullptr) return;
        const Result<EllipseSight> sight = make_ellipse_sight(view.camera, *seen);
        if (!sight) return;
        shot->sight = *sight;
        seen_in[frame.number] = true;
      });
  if (looked.is_interrupted) throw StartupError(ExitStatus::kWorkFailed, "interrupted: nothing was written");
  for (const EllipseShot& shot : shots) {
    const auto found = seen_in.find(shot.frame);
    if (found == seen_in.end())
      refuse(fmt::format("{} has no frame {}; it has {} pictures", arguments.recording, shot.frame, looked.frames));
    if (!found->second)
      throw StartupError(ExitStatus::kWorkFailed,
                         fmt::format("frame {} shows no landmark: take it again, or leave it out", shot.frame));
  }
}

std::string text_of(const EllipseFit& fit, const EllipseArguments& arguments) {
  const EllipseCalibration& c = fit.calibration;
  return fmt::format(
      "# Made by `ninedot calibrate ellipse` from {} centred and {} off-centre shots, focal length {:g} mm.\n"
      "# The distances come out with {:.2g} % (root mean square), {:.2g} % at most.{}\n"
      "[pose]\nsolver = \"ellipse\"\n\n"
      "[pose.ellipse]\nkmm_mm_per_px = {:.9g}\np1 = {:.9g}\np2 = {:.9g}\np3 = {:.9g}\ncu = {:.6g}\ncv = {:.6g}\n",
      fit.centred, fit.off_centre, arguments.focal_length_mm, 100 * fit.rms_share, 100 * fit.worst_share,
      fit.depends_on_distance ? "" : " They show no F(D') that changes with the distance.", c.kmm_mm_per_px, c.p1, c.p2,
      c.p3, c.cu, c.cv);
}

void run_ellipse(const EllipseArguments& arguments) {
  const Config config = arguments.config.empty() ? Config{} : read_config(arguments.config);
  std::vector<EllipseShot> shots = read_shots(arguments);
  const RecordingView view = view_of_recording(arguments.recording, arguments.camera, config);
  std::vector<std::string> inputs = files_of(config, {arguments.recording}, arguments.camera);
  inputs.insert(inputs.end(), {arguments.recording, arguments.config, arguments.shots_file});
  check_outputs({{"--out", arguments.out}}, inputs);
  OutputFile out(arguments.out);  // before the work, so that a folder that is not there is told at once
  see(shots, arguments, config, view);
  const EllipseFit fit = fit_ellipse_calibration(shots, view.camera, view.landmark, arguments.focal_length_mm);
  const std::string text = text_of(fit, arguments);
  out.write(text);
  out.finish();
  if (!arguments.out.empty() && arguments.out != "-") fmt::print(stderr, "{}", text);
}

}  // namespace

void add_calibrate_ellipse_command(CLI::App& group) {
  CLI::App* command = group.add_subcommand("ellipse", "Kmm, p1 to p3, cu and cv of solver \"ellipse\", from shots");
  const auto arguments = std::make_shared<EllipseArguments>();
  command->add_option("RECORDING", arguments->recording, "folder with frames/, or a .y4m file")->required();
  command->add_option("--shots", arguments->shots_file,
                      "CSV: frame,distance_mm and, of off-centre shots, centred_frame");
  command->add_option("--shot", arguments->shots, "one shot, FRAME:DISTANCE_MM or FRAME:DISTANCE_MM:CENTRED_FRAME");
  command->add_option("--focal-length-mm", arguments->focal_length_mm, "of the lens, as its maker says")
      ->required()
      ->check(CLI::Validator(
          [](const std::string& text) -> std::string {
            double mm = 0;  // CLI::Range lets what is no number through
            return read_number(text, mm) && mm >= 0.1 && mm <= 1000 ? "" : text + " is no length from 0.1 to 1000 mm";
          },
          "MM"));
  command->add_option("--config", arguments->config, "landmark; default: the default landmark");
  command->add_option("--camera", arguments->camera, "calibration; default: the recording's, then the configuration's");
  command->add_option("--out", arguments->out, "file for the lines of the configuration; default: standard output");
  command->callback([arguments] { run_ellipse(*arguments); });
}

}  // namespace ninedot
