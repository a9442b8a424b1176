// Writes docs/trust.md: is what the software is sure of true? Photographs without a landmark, things that look like
// one, and rendered views with exact truth. Fails when a limit is passed.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <thread>

#include "tests/bench/trust/csv.h"
#include "tests/bench/trust/drawn.h"
#include "tests/bench/trust/photographs.h"
#include "tests/bench/trust/run.h"

namespace ninedot::bench {
namespace {

constexpr const char* kUsage =
    "usage: trust [--seed N] [--frames N] [--only TEXT] [--half tune|held|both] [--photographs FOLDER] [--out "
    "FILE.md]\n"
    "             [--camera grey|colour] [--csv FILE] [--save FOLDER] [--threads N]\n"
    "  --seed N             another seed, other drawn pictures (1)\n"
    "  --frames N           pictures of each drawn kind (100)\n"
    "  --only TEXT          the kinds and groups whose name has TEXT in it\n"
    "  --camera KIND        grey, or colour: the same pictures as one with colours gives them, fitted otherwise "
    "(grey)\n"
    "  --half HALF          of the photographs: to tune by one, and hold the other back (both)\n"
    "  --photographs FOLDER made by tests/bench/trust/photographs.sh (build/photographs); all of them, whatever "
    "--frames\n"
    "  --out FILE.md        the page (standard output)\n"
    "  --csv FILE           a line per picture; a turn_deg near a multiple of 45 is a wrong numbering\n"
    "  --read FILE          another run's --csv instead of a run, so that several make one page; may be given again\n"
    "  --save FOLDER        the pictures that are wrong and valid, as PNG\n"
    "  --save-all FOLDER    all of them\n"
    "  --slowest N          with --save: instead, the N that took longest (tests/bench/trust/slowest.sh)\n"
    "Exit status: 0 all limits kept, 1 one is passed or a file can't be written, 2 wrong usage.\n";

struct Options {
  std::uint64_t seed = 1;
  int frames = 100;
  std::string only;
  std::string half = "both";
  CameraKind camera = CameraKind::kGrey;
  std::filesystem::path photographs = "build/photographs";
  std::filesystem::path out, csv, save;
  std::vector<std::filesystem::path> read;
  bool save_all = false;
  int slowest = 0;
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
};

bool parse(const std::vector<std::string_view>& arguments, Options& options) {
  for (std::size_t i = 0; i < arguments.size(); i += 2) {
    const std::string_view name = arguments[i];
    if (i + 1 == arguments.size()) return false;
    const std::string value(arguments[i + 1]);
    const int number = std::atoi(value.c_str());
    if (name == "--seed") {
      options.seed = static_cast<std::uint64_t>(std::atoll(value.c_str()));
    } else if (name == "--frames" && number > 0) {
      options.frames = number;
    } else if (name == "--only") {
      options.only = value;
    } else if (name == "--half" && (value == "tune" || value == "held" || value == "both")) {
      options.half = value;
    } else if (name == "--camera" && (value == "grey" || value == "colour")) {
      options.camera = value == "colour" ? CameraKind::kColour : CameraKind::kGrey;
    } else if (name == "--photographs") {
      options.photographs = value;
    } else if (name == "--out") {
      options.out = value;
    } else if (name == "--csv") {
      options.csv = value;
    } else if (name == "--read") {
      options.read.emplace_back(value);
    } else if (name == "--save" || name == "--save-all") {
      options.save = value, options.save_all = name == "--save-all";
    } else if (name == "--slowest" && number > 0) {
      options.slowest = number;
    } else if (name == "--threads" && number > 0) {
      options.threads = number;
    } else {
      return false;
    }
  }
  return true;
}

bool is_wanted(const Kind& kind, const Options& options) {
  return kind.name.find(options.only) != std::string::npos || kind.group.find(options.only) != std::string::npos;
}

void add_photographs(const Options& options, std::vector<Kind>& kinds, std::vector<Job>& jobs) {
  bool wanted = false;
  for (const Kind& kind : photograph_kinds()) {
    if (!is_wanted(kind, options)) continue;
    kinds.push_back(kind);
    wanted = true;
  }
  if (!wanted) return;
  const Half half = options.half == "tune" ? Half::kTune : options.half == "held" ? Half::kHeld : Half::kBoth;
  const std::vector<Job> photographs = photograph_jobs(options.photographs, half);
  if (photographs.empty() && options.read.empty())
    fmt::print(stderr, "trust: no photographs in {}: tests/bench/trust/photographs.sh gathers them\n",
               options.photographs.string());
  jobs.insert(jobs.end(), photographs.begin(), photographs.end());
}

// That makes the page again: only what changes it.
std::string command_of(const Options& options) {
  const Options usual;
  std::string command = "./dev trust";
  if (options.seed != usual.seed) command += fmt::format(" --seed {}", options.seed);
  if (options.frames != usual.frames) command += fmt::format(" --frames {}", options.frames);
  if (options.half != usual.half) command += fmt::format(" --half {}", options.half);
  if (options.camera == CameraKind::kColour) command += " --camera colour";
  if (!options.only.empty()) command += fmt::format(" --only '{}'", options.only);
  for (const auto& file : options.read) command += fmt::format(" --read {}", file.filename().string());
  return command;
}

bool write_page(const Options& options, const std::string& page) {
  if (options.out.empty()) {
    fmt::print("{}", page);
    return true;
  }
  std::ofstream file(options.out, std::ios::binary | std::ios::trunc);
  file << page;
  file.close();
  if (!file) fmt::print(stderr, "trust: cannot write {}: choose another place with --out\n", options.out.string());
  return static_cast<bool>(file);
}

// \return  false: said on standard error
bool draw_and_judge(const Options& options, const std::vector<Job>& jobs, Tallies& tallies) {
  RunOptions how{static_cast<unsigned>(options.threads),
                 options.camera,
                 nullptr,
                 options.save,
                 options.save_all,
                 static_cast<std::size_t>(options.slowest),
                 isatty(STDERR_FILENO) != 0};
  if (!options.csv.empty()) {
    how.csv = std::fopen(options.csv.c_str(), "w");
    if (how.csv == nullptr) {
      fmt::print(stderr, "trust: cannot write {}: choose another place with --csv\n", options.csv.string());
      return false;
    }
    fmt::print(how.csv, "{}", kCsvHeader);
  }
  tallies = run_jobs(jobs, how);
  if (how.csv == nullptr || std::fclose(how.csv) == 0) return true;
  fmt::print(stderr, "trust: {} is incomplete: is the disk full?\n", options.csv.string());
  return false;
}

bool read_runs(const Options& options, Tallies& tallies) {
  for (const std::filesystem::path& file : options.read)
    if (!add_csv(file, tallies)) {
      fmt::print(stderr, "trust: {} is not what --csv writes\n", file.string());
      return false;
    }
  return true;
}

int count_over_limit(const std::vector<Kind>& kinds, const Tallies& tallies) {
  int over = 0;
  for (const Kind& kind : kinds) {
    const auto tally = tallies.find(kind.name);
    if (tally == tallies.end() || !is_over_limit(kind, tally->second)) continue;
    fmt::print(stderr, "trust: {}: {} of {} wrong and valid, over the limit\n", kind.name, tally->second.wrong,
               tally->second.pictures);
    ++over;
  }
  return over;
}

int run(const Options& options) {
  std::vector<Kind> kinds;
  std::vector<Job> jobs;
  add_photographs(options, kinds, jobs);
  const DrawnJobs drawn =
      drawn_jobs([&](const Kind& kind) { return is_wanted(kind, options); }, options.frames, options.seed);
  kinds.insert(kinds.end(), drawn.kinds.begin(), drawn.kinds.end());
  jobs.insert(jobs.end(), drawn.jobs.begin(), drawn.jobs.end());

  const TrustRun about{usual_work_ms(), command_of(options)};
  Tallies tallies;
  if (!(options.read.empty() ? draw_and_judge(options, jobs, tallies) : read_runs(options, tallies))) return 1;
  if (!write_page(options, trust_page(kinds, tallies, about))) return 1;
  return count_over_limit(kinds, tallies) > 0 ? 1 : 0;
}

}  // namespace
}  // namespace ninedot::bench

int main(int argc, char** argv) {
  ninedot::bench::Options options;
  if (argc == 2 && std::string_view(argv[1]) == "--help") {
    fmt::print("{}", ninedot::bench::kUsage);
    return 0;
  }
  try {
    if (ninedot::bench::parse({argv + 1, argv + argc}, options)) return ninedot::bench::run(options);
  } catch (const std::filesystem::filesystem_error& error) {
    fmt::print(stderr, "trust: {}: {}\n", error.path1().string(), error.code().message());
    return 1;
  }
  fmt::print(stderr, "{}", ninedot::bench::kUsage);
  return 2;
}
