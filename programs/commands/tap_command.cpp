// `ninedot tap`: what a running service sees, without stopping it: a line of its report, a picture, or a recording.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>
#include <string>
#include <thread>

#include "base/reason.h"
#include "base/refusal.h"
#include "base/startup_error.h"
#include "calibrate/camera_file.h"
#include "config/config.h"
#include "drawing/overlay.h"
#include "drivers/picture/picture_file.h"
#include "drivers/picture/ycbcr.h"
#include "drivers/posix/signals.h"
#include "drivers/recording/recording_writer.h"
#include "drivers/tap/tap_reader.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/commands.h"
#include "programs/commands/named_option.h"
#include "programs/commands/output_check.h"
#include "programs/commands/progress.h"
#include "programs/tap/tap_frame.h"
#include "programs/tap/tap_lease.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// The service looks for readers every 20 ms; a camera that gives nothing for so long gives nothing.
constexpr auto kPatience = 3s;
// Between two looks: a small part of a frame period, and no load.
constexpr auto kPause = 2ms;

struct TapArguments {
  std::string config, path = TapConfig{}.path;
  std::string out, record;
  bool overlay = false, latencies = false;
  std::uint64_t frames = 1;
};

class Tap {
 public:
  Tap(const std::string& path, TapDemand demand) : path_(path), reader_(path) { reader_.announce(demand); }

  /// The next frame that is newer than the last one that was asked for.
  const TapCopy& next() {
    const MonoTime give_up_at = mono_now() + kPatience;
    while (!reader_.copy_newest(copy_)) {
      if (!reader_.is_alive()) fail("the service has ended");
      if (mono_now() > give_up_at)
        fail(fmt::format("no frame for {} s: `ninedot status` says how the camera is", kPatience.count()));
      std::this_thread::sleep_for(kPause);
    }
    return copy_;
  }
  const TapHeader& header() const noexcept { return reader_.header(); }
  [[noreturn]] void fail(const std::string& what) const {
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", path_, what));
  }

 private:
  const std::string path_;
  TapReader reader_;
  TapCopy copy_;
};

/// What came nearest to a landmark where none was found, in brackets; else nothing.
std::string nearest_guess(const TapFrame& frame) {
  if (frame.search.has_failed == 0 || frame.search.refusal == 0) return {};
  return fmt::format(" (of what comes nearest: {})", refusal_sentence(frame.search.refusal));
}

std::string report_line(const TapFrame& frame) {
  const std::string about =
      fmt::format("frame {}, latency {:.1f} ms", frame.number, static_cast<double>(frame.latency_ns) / 1e6);
  if ((frame.flags & tap_flag::kValid) == 0)
    return fmt::format("not valid: {}{}; {}", reason_sentence(frame.reason), nearest_guess(frame), about);
  const TapPose& pose = frame.camera_in_world;
  return fmt::format(
      "valid: x {:.3f} y {:.3f} z {:.3f} mm, 1-sigma {:.3f} {:.3f} {:.3f} mm, landmark {}, {} of 9 dots, residual "
      "{:.3f} "
      "px, ambiguity {:.3f}; {}",
      pose.position_mm[0], pose.position_mm[1], pose.position_mm[2], pose.sigma_mm[0], pose.sigma_mm[1],
      pose.sigma_mm[2], frame.landmark_id, frame.dots_used, frame.rms_px, frame.ambiguity, about);
}

/// How long frames took from the middle of the exposure to the report, all since the start: a line for each bin from
/// the first to the last that is not empty.
void print_latencies(const TapFrame& frame) {
  const auto& bins = frame.latency_bins;
  const std::uint64_t sum = std::accumulate(bins.begin(), bins.end(), std::uint64_t{0});
  fmt::print("latency of {} frames since the start ({} processed)\n", sum, frame.frames_processed);
  constexpr double kLongestBar = 50;
  const std::uint32_t largest = *std::max_element(bins.begin(), bins.end());
  std::size_t first = 0, last = bins.size();
  while (first < last && bins[first] == 0) ++first;
  while (last > first && bins[last - 1] == 0) --last;
  for (std::size_t i = first; i < last; ++i) {
    const bool is_open = i + 1 == bins.size();  // takes all that is longer than the bin before
    const double edge_ms = kTapFirstBin_us * std::exp2(static_cast<double>(is_open ? i - 1 : i) / 4) / 1000;
    fmt::print("{} {:>7.2f} ms {:>10} {:>6.2f} % {}\n", is_open ? "above" : "up to", edge_ms, bins[i],
               100.0 * bins[i] / static_cast<double>(sum),
               std::string(static_cast<std::size_t>(std::ceil(kLongestBar * bins[i] / largest)), '#'));
  }
}

void draw(const Tap& tap, const TapCopy& copy, RgbPicture& picture) {
  LandmarkObservation seen;
  const bool has_dots = observation_of(copy.frame, seen);
  const auto spots = std::make_unique<BlobList>();
  const auto failed = search_of(copy.frame, *spots);
  draw_overlay(copy.luma(), report_of(copy.frame), has_dots ? &seen : nullptr, failed ? &*failed : nullptr,
               camera_of(tap.header()), landmark_of(tap.header()), 0, picture);
}

void save_picture(Tap& tap, const TapArguments& arguments) {
  const TapCopy& copy = tap.next();
  if (copy.luma().empty()) tap.fail("this frame came without a picture: it is larger than the calibration's");
  Result<std::size_t> written = std::size_t{0};
  if (arguments.overlay) {
    RgbPicture picture;
    draw(tap, copy, picture);
    written = write_png_rgb(arguments.out, picture.pixels, {picture.width_px, picture.height_px});
  } else if (const ChromaView chroma = copy.chroma(); !chroma.empty()) {
    const PictureSize size{copy.luma().width_px, copy.luma().height_px};
    std::vector<std::uint8_t> rgb(3 * size.pixel_count());
    rgb_from_ycbcr(copy.luma(), chroma, rgb);
    written = write_png_rgb(arguments.out, rgb, size);
  } else {
    written = write_png_grey(arguments.out, copy.luma());
  }
  if (!written)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("{} cannot be written: {}", arguments.out, std::strerror(written.error().os_errno)));
  fmt::print("{}\n", report_line(copy.frame));
}

void record(Tap& tap, const TapArguments& arguments) {
  const TerminationSignals signals;
  RecordingWriter writer(arguments.record, format_camera(camera_of(tap.header()), "recorded"));
  Progress progress;
  std::uint64_t lost = 0, before = 0;
  while (writer.frame_count() < arguments.frames && signals.wait(0ns) == 0) {
    const TapCopy& copy = tap.next();
    const FrameLease lease = lease_of(copy, before);
    before = copy.publication;
    lost += lease.dropped_before;
    if (const auto number = writer.add(lease); !number)
      throw StartupError(ExitStatus::kWorkFailed,
                         fmt::format("{}: {}; the {} frames before are kept", arguments.record,
                                     std::strerror(number.error().os_errno), writer.frame_count()));
    if (progress.is_due()) progress.show(fmt::format("frame {} of {}", writer.frame_count(), arguments.frames));
  }
  progress.clear();
  fmt::print("{}: {} frames{}\n", arguments.record, writer.frame_count(),
             lost > 0 ? fmt::format(", {} missed while the disk wrote", lost) : std::string());
}

void run_tap(const TapArguments& arguments) {
  if (arguments.overlay && arguments.out.empty())
    throw StartupError(ExitStatus::kWrongUsage, "--overlay draws into the picture of --out: name one");
  if (!arguments.out.empty() && !arguments.record.empty())
    throw StartupError(ExitStatus::kWrongUsage, "one of --out and --record at a time");
  if (arguments.latencies && !(arguments.out.empty() && arguments.record.empty()))
    throw StartupError(ExitStatus::kWrongUsage, "--latencies prints, and saves nothing: leave --out and --record away");
  std::string path = arguments.path;
  if (!arguments.config.empty()) {
    const Config config = read_config(arguments.config);
    if (!config.tap.enabled)
      throw StartupError(ExitStatus::kWorkFailed,
                         arguments.config + ": no tap is configured: write `enabled = true` under [tap]");
    check_outputs({{"--out", arguments.out}}, {arguments.config, config.map, config.tap.path});
    path = config.tap.path;
  }
  Tap tap(path, arguments.frames > 1 ? TapDemand::kEvery : TapDemand::kSome);
  if (arguments.latencies) return print_latencies(tap.next().frame);
  if (!arguments.out.empty()) return save_picture(tap, arguments);
  if (!arguments.record.empty()) return record(tap, arguments);
  for (std::uint64_t i = 0; i < arguments.frames; ++i) fmt::print("{}\n", report_line(tap.next().frame));
}

}  // namespace

void add_tap_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("tap", "Show, save or record what a running service sees, without stopping it");
  const auto arguments = std::make_shared<TapArguments>();
  auto* config = command->add_option("--config", arguments->config, "the service's configuration: its [tap] is read")
                     ->check(is_named());
  command->add_option("--path", arguments->path, "the tap itself; default: " + arguments->path)->excludes(config);
  command->add_option("--out", arguments->out, "save the newest picture as PNG")->check(is_named());
  command->add_flag("--overlay", arguments->overlay, "with what was found drawn into it");
  command->add_option("--record", arguments->record, "a new or empty folder: record --frames frames into it")
      ->check(is_named());
  command->add_flag("--latencies", arguments->latencies,
                    "how many frames since the service's start took how long, from the exposure to the report");
  command->add_option("--frames", arguments->frames, "how many frames to record, or lines to print; default: 1")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{999'999'999}));
  command->callback([arguments] { run_tap(*arguments); });
}

}  // namespace ninedot
