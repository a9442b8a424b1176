/// `ninedot pattern`: prints a landmark to exact size.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "base/startup_error.h"
#include "programs/commands/commands.h"
#include "programs/commands/pattern_output.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

struct PatternCommand {
  PatternOptions options;
  int landmark_id = 0;
  std::string out;
  bool has_code = false;
};

void print_pattern(PatternCommand& command) {
  PatternOptions& options = command.options;
  if (command.has_code) {
    if (options.code.empty()) options.code = "-";  // refused below, with the line that says what a code is
    options.landmark_id = known_id(options.code).value_or(-1);
  } else {
    const std::optional<std::string> code = known_code(command.landmark_id);
    if (!code)
      throw StartupError(
          ExitStatus::kWrongUsage,
          fmt::format("--id {}: give 0, black and white, or 1 to 5; for another landmark give its --code",
                      command.landmark_id));
    options.code = *code;
    options.landmark_id = command.landmark_id;
  }
  const PatternPage page = make_pattern_page(options);
  write_pattern(page, command.out);
  fmt::print(
      "{}: {}\nprint it at 100 %, check that the bar is 100 mm long, and configure\n"
      "  [landmark]\n  ring_radius_mm = {:g}\n  dot_diameter_mm = {:g}\n  centre_diameter_mm = {:g}\n",
      command.out, page.title, options.ring_radius_mm, options.dot_diameter_mm, options.centre_diameter_mm);
}

}  // namespace

void add_pattern_command(CLI::App& app) {
  CLI::App* sub = app.add_subcommand("pattern", "Write a landmark as SVG or PDF that prints to exact size");
  const auto command = std::make_shared<PatternCommand>();
  PatternOptions& options = command->options;
  CLI::Option* code =
      sub->add_option("--code", options.code, "Colours of P1 to P8: eight of K R G B; none = black and white");
  CLI::Option* id =
      sub->add_option("--id", command->landmark_id, "A known landmark: 0 (black and white), 1 to 5 (coloured)");
  code->excludes(id);
  sub->add_option("--sheet", options.sheet, "Paper: a0 to a5, or WIDTHxHEIGHT in mm")->capture_default_str();
  sub->add_option("--ring-radius-mm", options.ring_radius_mm, "Radius of the ring P1 to P8")->capture_default_str();
  sub->add_option("--dot-diameter-mm", options.dot_diameter_mm, "Diameter of P1 to P8")->capture_default_str();
  sub->add_option("--centre-diameter-mm", options.centre_diameter_mm, "Diameter of P9")->capture_default_str();
  sub->add_option("--out", command->out, "FILE.svg or FILE.pdf")->required();
  sub->callback([command, code] {
    command->has_code = code->count() > 0;
    print_pattern(*command);
  });
}

}  // namespace ninedot
