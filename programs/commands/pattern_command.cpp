/// `ninedot pattern`: prints landmarks to exact size.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drawing/grid_page.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/commands.h"
#include "programs/commands/dot_grid_option.h"
#include "programs/commands/named_option.h"
#include "programs/commands/output_check.h"
#include "programs/commands/pattern_choice.h"
#include "programs/commands/pattern_output.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

/// For a landmark whose code has no number of its own: far from those of the dictionary.
constexpr int kFreeId = 1000;

struct PatternCommand {
  PatternOptions lengths;  ///< and the paper
  std::vector<std::string> ids{"0"};
  std::string code;
  bool has_code = false;
  bool all_of_map = false;
  std::string config;  ///< the file with the map
  std::string grid;    ///< of dots, in place of landmarks
  std::string out;
};

std::vector<PatternPage> make_pages(const std::vector<PatternOptions>& landmarks) {
  std::vector<PatternPage> pages;
  for (const PatternOptions& landmark : landmarks) pages.push_back(make_pattern_page(landmark));
  return pages;
}

/// The rest of what is printed is for a configuration file, so this is a comment there.
void print_heading(const std::string& out, const std::string& what) {
  fmt::print("# {}: {}\n# Print at 100 %, check that the bar is 100 mm long", out, what);
}

void print_configuration(const std::vector<PatternOptions>& landmarks) {
  const PatternOptions& o = landmarks.front();
  fmt::print(", and configure:\n[landmark]\nring_radius_mm = {:g}\ndot_diameter_mm = {:g}\ncentre_diameter_mm = {:g}\n",
             o.ring_radius_mm, o.dot_diameter_mm, o.centre_diameter_mm);
  for (const PatternOptions& landmark : landmarks) {
    if (landmark.landmark_id)
      fmt::print("[[landmarks]]\nid = {}\n", *landmark.landmark_id);
    else
      fmt::print("[[landmarks]]\nid = {}  # or another number that is free\n", kFreeId);
    if (!is_black_and_white(landmark.code)) fmt::print("code = \"{}\"\n", landmark.code);
  }
}

void print_chosen(const PatternCommand& command) {
  const std::vector<PatternOptions> landmarks =
      command.has_code ? std::vector{landmark_of_code(command.code.empty() ? "-" : command.code, command.lengths)}
                       : known_landmarks(command.ids, command.lengths);
  const std::vector<PatternPage> pages = make_pages(landmarks);
  write_pattern(pages, command.out);
  print_heading(command.out,
                pages.size() == 1 ? pages.front().title : fmt::format("{} landmarks, one a page", pages.size()));
  print_configuration(landmarks);
}

void print_map(const PatternCommand& command) {
  const Config config = read_config(command.config);
  check_outputs({{"--out", command.out}}, {command.config, config.map});
  PatternOptions lengths = command.lengths;
  lengths.ring_radius_mm = config.landmark.ring_radius_mm;
  lengths.dot_diameter_mm = config.landmark.dot_diameter_mm;
  lengths.centre_diameter_mm = config.landmark.centre_diameter_mm;
  const std::vector<ListedLandmark> list = landmarks_of_map(config);
  std::vector<PatternPage> pages = make_contents_pages(list, lengths);
  const std::size_t contents = pages.size();
  for (PatternPage& page : make_pages(listed_landmarks(list, lengths))) pages.push_back(std::move(page));
  write_pattern(pages, command.out);
  print_heading(command.out,
                fmt::format("{} of contents, then one for each landmark of {}: {}",
                            contents == 1 ? "a page" : fmt::format("{} pages", contents), command.config, list.size()));
  fmt::print("\n");
}

void print_grid(const PatternCommand& command) {
  const PatternPage page = make_grid_page(read_dot_grid(command.grid), command.lengths.sheet);
  write_pattern({&page, 1}, command.out);
  print_heading(command.out, page.title);
  fmt::print(", and give `ninedot calibrate camera` the same --grid {}\n", command.grid);
}

}  // namespace

void add_pattern_command(CLI::App& app) {
  CLI::App* sub = app.add_subcommand("pattern", "Write landmarks as SVG or PDF that print to exact size");
  const auto command = std::make_shared<PatternCommand>();
  PatternOptions& lengths = command->lengths;
  CLI::Option* id =
      sub->add_option("--id,--ids", command->ids,
                      fmt::format("Known landmarks, a page each: 0 (black and white, the default), 1 to "
                                  "{0} (coloured); 1-16 is a row. Codes differ in 3 dots at least however "
                                  "the sheets are turned, those of 1 to {1} in 4",
                                  kKnownCodes, kFarCodes))
          ->delimiter(',');
  CLI::Option* code =
      sub->add_option("--code", command->code, "Colours of P1 to P8 of a landmark of your own: eight of K R G B");
  CLI::Option* all =
      sub->add_flag("--all", command->all_of_map, "Every landmark of a configuration's map, after a page of contents");
  CLI::Option* config = sub->add_option("--config", command->config, "The configuration file for --all");
  CLI::Option* grid = sub->add_option("--grid", command->grid,
                                      "A grid of dots for calibrations, COLUMNSxROWS@PITCH in mm, in place of "
                                      "landmarks: 7x9@25 fills an A4 sheet");
  grid->excludes(id)->excludes(code)->excludes(all);
  id->excludes(code)->excludes(all);
  code->excludes(all);
  all->needs(config);
  config->needs(all);
  sub->add_option("--sheet", lengths.sheet, "Paper: a0 to a5, letter, or WIDTHxHEIGHT in mm")->capture_default_str();
  const auto add_length = [&](const char* name, double& length_mm, const char* meaning) {
    sub->add_option(name, length_mm, meaning)->capture_default_str()->excludes(config)->excludes(grid);
  };
  add_length("--ring-radius-mm", lengths.ring_radius_mm, "Radius of the ring P1 to P8");
  add_length("--dot-diameter-mm", lengths.dot_diameter_mm, "Diameter of P1 to P8");
  add_length("--centre-diameter-mm", lengths.centre_diameter_mm, "Diameter of P9");
  sub->add_option("--out", command->out, "FILE.svg, or FILE.pdf, which may have several pages")
      ->required()
      ->check(is_named());
  sub->callback([command, code] {
    if (!command->grid.empty()) return print_grid(*command);
    command->has_code = code->count() > 0;
    command->all_of_map ? print_map(*command) : print_chosen(*command);
  });
}

}  // namespace ninedot
