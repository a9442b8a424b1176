/// bench_rivals FOLDER [--rows FILE] [--repeats N]: detection and pose of this project beside others', one thread, on
/// the same pictures in the same run, taking turns picture by picture so that a busy machine slows all of them alike.
/// bench_rivals FOLDER --once full|tracking|apriltag: one pass of one of them inside `ninedot_measured`, for callgrind;
/// prints the number of frames.
///
/// The recordings show our landmark; the rivals scan those pictures without finding anything. So that their pose is
/// paid for as well, they also get the pictures with their own tag in the landmark's place (tag_picture.h).
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "base/mono_time.h"
#include "base/startup_error.h"
#include "tests/bench/contenders.h"
#include "tests/bench/limits.h"
#include "tests/bench/tag_picture.h"

/// One call of one contender, under a name that callgrind can be told to collect in.
extern "C" [[gnu::noinline]] bool ninedot_measured(ninedot::bench::Contender& contender,
                                                   const ninedot::ImageView& luma) {
  return contender.locate(luma).has_value();
}

namespace {

using namespace ninedot;
using namespace ninedot::bench;

struct Options {
  std::string folder;
  std::string rows_path;
  std::string once;
  int repeats = 15;
};

struct BenchFrame {
  std::vector<std::uint8_t> tagged;
  const CaseFrame* frame;
};

struct BenchCase {
  CaseFolder recording;
  std::vector<BenchFrame> frames;
};

/// One contender on one kind of picture; [i] is the frame.
struct Lane {
  std::string name;
  bool tagged = false;
  std::vector<double> median_us;
  std::vector<double> errors_percent;
  std::size_t found = 0;
};

/// The recordings made for comparing (positions, offcentre) where they exist, else all; frames with exactly one
/// landmark.
std::vector<BenchCase> read_cases(const std::string& folder) {
  std::vector<std::string> paths = find_cases(folder), chosen;
  std::copy_if(paths.begin(), paths.end(), std::back_inserter(chosen),
               [](const std::string& path) { return path.ends_with("/positions") || path.ends_with("/offcentre"); });
  std::vector<BenchCase> cases;
  for (const std::string& path : chosen.empty() ? paths : chosen) {
    cases.push_back({read_case(path), {}});
    BenchCase& added = cases.back();
    for (const CaseFrame& frame : added.recording.frames) {
      if (frame.landmarks.size() == 1) added.frames.push_back({paste_tag(added.recording, frame), &frame});
    }
  }
  return cases;
}

double median_of(const std::vector<double>& values) { return median(values).value_or(0); }

/// Times one frame `repeats` times in every lane, in turns.
void time_frame(const BenchCase& bench_case, const BenchFrame& frame, const std::vector<Contender*>& contenders,
                int repeats, std::vector<Lane>& lanes) {
  const ImageView plain = bench_case.recording.view(*frame.frame);
  ImageView tagged = plain;
  tagged.pixels = frame.tagged.data();
  const TruePose& truth = frame.frame->landmarks.front();
  std::vector<std::vector<double>> times_us(lanes.size());
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (Contender* const contender : contenders) contender->prepare(plain);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const MonoTime started = mono_now();
      const auto position_m = contenders[i]->locate(lanes[i].tagged ? tagged : plain);
      times_us[i].push_back(std::chrono::duration<double, std::micro>(mono_now() - started).count());
      if (repeat > 0 || !position_m) continue;
      ++lanes[i].found;
      lanes[i].errors_percent.push_back(100 * (*position_m - truth.T_landmark_camera.translation_m).norm() /
                                        truth.distance_m());
    }
  }
  for (std::size_t i = 0; i < lanes.size(); ++i) lanes[i].median_us.push_back(median_of(times_us[i]));
}

/// Lane 0 is our full search, lane 1 our tracking of a still landmark, lane 2 that of a moving one.
std::vector<Lane> race(const std::vector<BenchCase>& cases, int repeats) {
  std::vector<Lane> lanes;
  for (const BenchCase& bench_case : cases) {
    const CameraModel& camera = bench_case.recording.camera;
    const auto full = make_full_search(camera), still = make_tracking(camera, 0), moving = make_tracking(camera, 2),
               april1 = make_apriltag(camera, 1), april2 = make_apriltag(camera, 2), aruco = make_aruco(camera);
    const std::vector<Contender*> contenders{full.get(),   still.get(),  moving.get(), april1.get(), april1.get(),
                                             april2.get(), april2.get(), aruco.get(),  aruco.get()};
    if (lanes.empty()) {
      for (const Contender* const contender : contenders) {
        const bool second = !lanes.empty() && lanes.back().name == contender->name();
        lanes.push_back({contender->name(), second, {}, {}, 0});
      }
    }
    for (const BenchFrame& frame : bench_case.frames) time_frame(bench_case, frame, contenders, repeats, lanes);
  }
  return lanes;
}

/// Median over the pictures of (time of `slow`) / (time of `fast`).
double times_faster(const Lane& fast, const Lane& slow) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < fast.median_us.size(); ++i) ratios.push_back(slow.median_us[i] / fast.median_us[i]);
  return median_of(ratios);
}

void print_lanes(const std::vector<Lane>& lanes) {
  fmt::print(
      "| one thread, {} pictures | on | found | median ms | times our full search | median position error, % of "
      "distance |\n",
      lanes[0].median_us.size());
  fmt::print("|---|---|---|---|---|---|\n");
  for (const Lane& lane : lanes) {
    fmt::print("| {} | {} | {} | {:.3f} | {:.2f} | {} |\n", lane.name,
               lane.tagged ? "pictures with its tag" : "the recording", lane.found, median_of(lane.median_us) / 1000,
               times_faster(lanes[0], lane),
               lane.errors_percent.empty() ? "-" : fmt::format("{:.3f}", median_of(lane.errors_percent)));
  }
}

/// The rival's slower kind of picture would flatter us: the limit is held against the faster one.
LimitRow rival_row(const std::vector<Lane>& lanes, std::size_t rival, double factor, const std::string& to_reach) {
  const double plain = times_faster(lanes[0], lanes[rival]), tagged = times_faster(lanes[0], lanes[rival + 1]);
  const bool reached = std::min(plain, tagged) >= factor && lanes[0].found == lanes[0].median_us.size();
  return {"speed", to_reach,
          fmt::format(
              "1/{:.1f} on the same pictures, 1/{:.1f} with its tag in them ({:.2f} ms against {:.2f} and {:.2f} ms)",
              plain, tagged, median_of(lanes[0].median_us) / 1000, median_of(lanes[rival].median_us) / 1000,
              median_of(lanes[rival + 1].median_us) / 1000),
          reached ? Verdict::kReached : Verdict::kMissed};
}

std::vector<LimitRow> limit_rows(const std::vector<Lane>& lanes) {
  std::vector<LimitRow> rows;
  rows.push_back(rival_row(lanes, 3, 12, "full search and pose <= 1/12 of the time of AprilTag 3 (quad_decimate 1)"));
  rows.push_back(rival_row(lanes, 5, 3, "full search and pose <= 1/3 of the time of AprilTag 3 (quad_decimate 2)"));
  const double part = 1 / times_faster(lanes[1], lanes[0]);
  const bool reached = part <= 0.2 && lanes[1].found == lanes[1].median_us.size();
  rows.push_back({"speed", "tracking and pose <= 1/5 of the full search's time",
                  fmt::format("1/{:.1f} ({:.3f} ms) still, 1/{:.1f} when it moves by 2 px per frame", 1 / part,
                              median_of(lanes[1].median_us) / 1000, times_faster(lanes[2], lanes[0])),
                  reached ? Verdict::kReached : Verdict::kMissed});
  return rows;
}

/// One pass over all pictures for callgrind.
void measure_once(const std::vector<BenchCase>& cases, const std::string& what) {
  int frames = 0, found = 0;
  for (const BenchCase& bench_case : cases) {
    const CameraModel& camera = bench_case.recording.camera;
    const auto contender = what == "full"       ? make_full_search(camera)
                           : what == "tracking" ? make_tracking(camera, 0)
                                                : make_apriltag(camera, 1);
    for (const BenchFrame& frame : bench_case.frames) {
      ImageView luma = bench_case.recording.view(*frame.frame);
      contender->prepare(luma);
      if (contender->looks_for_tag()) luma.pixels = frame.tagged.data();
      found += ninedot_measured(*contender, luma) ? 1 : 0;
      ++frames;
    }
  }
  fmt::print("{} {}\n", frames, found);
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--rows" && i + 1 < argc) {
      options.rows_path = argv[++i];
    } else if (argument == "--once" && i + 1 < argc) {
      options.once = argv[++i];
    } else if (argument == "--repeats" && i + 1 < argc) {
      options.repeats = std::max(1, std::atoi(argv[++i]));
    } else {
      options.folder = argument;
    }
  }
  const bool known =
      options.once.empty() || options.once == "full" || options.once == "tracking" || options.once == "apriltag";
  if (options.folder.empty() || !known) {
    throw StartupError(ExitStatus::kWrongUsage,
                       "usage: bench_rivals FOLDER [--rows FILE] [--repeats N] | FOLDER --once full|tracking|apriltag");
  }
  return options;
}

void compare(const Options& options) {
  const auto cases = read_cases(options.folder);
  if (!options.once.empty()) return measure_once(cases, options.once);
  const auto lanes = race(cases, options.repeats);
  if (lanes.empty() || lanes[0].median_us.empty())
    throw StartupError(ExitStatus::kWrongUsage, options.folder + ": no picture with exactly one landmark");
  print_lanes(lanes);
  if (options.rows_path.empty()) return;
  std::ofstream rows(options.rows_path, std::ios::app);
  for (const LimitRow& row : limit_rows(lanes)) rows << markdown_row(row);
  if (!rows.flush()) throw StartupError(ExitStatus::kWorkFailed, options.rows_path + ": can't be written");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    compare(parse(argc, argv));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_rivals: {}\n", error.what());
    return 2;
  }
}
