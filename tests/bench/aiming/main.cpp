// Aiming in closed loop: writes docs/aiming.md and its plots, or tunes the plain controller that it compares with.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "drivers/posix/output_file.h"
#include "programs/commands/progress.h"
#include "programs/program.h"
#include "tests/bench/aiming/report.h"

namespace ninedot::bench {
namespace {

void write_page(const std::string& out) {
  Progress progress;
  const auto files = aiming_files({}, [&](const std::string& words) { progress.show(words); });
  progress.clear();
  const std::filesystem::path folder = std::filesystem::path(out).parent_path();
  for (const AimingFile& file : files) {
    OutputFile output(file.name == "aiming.md" ? out : (folder / file.name).string());
    output.write(file.text);
    output.finish();
  }
}

void print_gains() {
  const PidGains best = tuned_gains([](const std::string& line) { fmt::print("{}\n", line); });
  fmt::print("best: kp {} ki {} kd {}\n", best.kp_deg_s_px, best.ki_deg_s2_px, best.kd_deg_px);
}

}  // namespace
}  // namespace ninedot::bench

// NOLINTNEXTLINE(bugprone-exception-escape): CLI11 throws here for a mistake in the declarations below, before any run
int main(int argc, char** argv) {
  CLI::App app{"Aiming of a simulated head, beside a plain PID controller.", "bench_aiming"};
  std::string out;
  bool tune = false;
  auto* const page = app.add_option("--out", out, "the page; its plots go beside it");
  app.add_flag("--tune", tune, "search the plain controller's gains, and print them")->excludes(page);
  return ninedot::run_program(app, argc, argv, [&] {
    if (tune) return ninedot::bench::print_gains();
    ninedot::bench::write_page(out.empty() ? "docs/aiming.md" : out);
  });
}
