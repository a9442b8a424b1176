// `ninedot pattern` as it is typed.
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "base/units.h"
#include "config/config_checks.h"
#include "config/map_file.h"
#include "programs/commands/commands.h"
#include "programs/commands/pattern_choice.h"
#include "world/landmark_codes.h"
#include "world/landmark_map.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

class PatternCommandLine : public testing::Test {
 protected:
  PatternCommandLine()
      : out_(fs::temp_directory_path() / ("ninedot_pattern_command_" + std::to_string(::getpid()) + ".svg")) {}
  ~PatternCommandLine() override { fs::remove(out_); }

  /// What `ninedot pattern WORDS --out FILE.svg` writes.
  std::string written_by(std::vector<std::string> words) {
    testing::internal::CaptureStdout();
    try {
      words.insert(words.begin(), "pattern");
      words.insert(words.end(), {"--out", out_.string()});
      run(words);
    } catch (...) {
      testing::internal::GetCapturedStdout();
      throw;
    }
    printed_ = testing::internal::GetCapturedStdout();
    std::ifstream file(out_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void use_pdf() { out_.replace_extension(".pdf"); }
  void expect_wrong_usage(const std::vector<std::string>& words) {
    try {
      written_by(words);
      ADD_FAILURE() << testing::PrintToString(words) << ": accepted";
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    }
    EXPECT_FALSE(fs::exists(out_));
  }
  static void run(const std::vector<std::string>& words) {
    CLI::App app;
    add_pattern_command(app);
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 takes them from the back
  }

  fs::path out_;
  std::string printed_;
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(PatternCommandLine, WritesTheBlackAndWhiteLandmarkOnA4ByDefault) {
  const std::string svg = written_by({});
  EXPECT_TRUE(has(svg, "width=\"210mm\" height=\"297mm\""));
  EXPECT_TRUE(has(svg, "ninedot landmark 0, black and white"));
  EXPECT_FALSE(has(svg, "#cc0000"));
}

TEST_F(PatternCommandLine, TakesAKnownLandmarkByItsNumberOrItsCode) {
  const std::string by_number = written_by({"--id", "3"});
  EXPECT_TRUE(has(by_number, "ninedot landmark 3, code KKGRRBGB"));
  EXPECT_EQ(written_by({"--code", "KKGRRBGB"}), by_number);
}

TEST_F(PatternCommandLine, TakesACodeThatHasNoNumber) {
  EXPECT_TRUE(has(written_by({"--code", "KKKKKKKR"}), "ninedot landmark, code KKKKKKKR"));
}

TEST_F(PatternCommandLine, PrintsWhatAConfigurationTakes) {
  use_pdf();
  written_by({"--id", "3", "9-10", "0"});
  ConfigProblems problems;
  const Config config = parse_config(printed_, "printed", problems);
  ASSERT_EQ(config.landmarks.size(), 4U);
  const int ids[] = {3, 9, 10, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(config.landmarks[i].id, ids[i]);
    EXPECT_EQ(config.landmarks[i].code, known_code(ids[i]).value());
  }
  written_by({"--code", "KKKKKRGR"});
  EXPECT_EQ(parse_config(printed_, "printed", problems).landmarks.at(0).code, "KKKKKRGR");
}

TEST_F(PatternCommandLine, TakesSeveralLandmarksInMoreThanOneWay) {
  use_pdf();
  const std::string pdf = written_by({"--id", "1", "2", "3"});
  EXPECT_TRUE(has(pdf, "/Count 3"));
  EXPECT_EQ(written_by({"--ids", "1-3"}), pdf);
  EXPECT_EQ(written_by({"--id", "1,2-3"}), pdf);
}

TEST_F(PatternCommandLine, TakesAllLandmarksOfAMapByRisingIdAfterTheContents) {
  use_pdf();
  const std::string config = out_.string() + ".toml";
  std::ofstream(config) << "[landmark]\nring_radius_mm = 70\n[[landmarks]]\nid = 12\ncode = \"KRGBKKRB\"\n"
                           "position_mm = [1500, 2, 3]\n[[landmarks]]\nid = 4\n";
  const std::string pdf = written_by({"--all", "--config", config});
  EXPECT_TRUE(has(pdf, "/Count 3"));
  EXPECT_TRUE(has(pdf, "(2 sheets: ring radius 70 mm, dots 25.4 mm, centre dot 50.8 mm in diameter)"));
  EXPECT_TRUE(has(pdf, "(1500.0)"));
  const std::size_t first = pdf.find("(ninedot landmark 4, black and white)");
  const std::size_t second = pdf.find("(ninedot landmark 12, code KRGBKKRB)");
  EXPECT_LT(first, second);
  EXPECT_NE(second, std::string::npos);
  std::ofstream(config) << "[camera]\n";
  EXPECT_TRUE(has(written_by({"--all", "--config", config}), "(ninedot landmark 0, black and white)"));
  std::ofstream(config) << "[[landmarks]]\nid = 4\ncode = \"RRRRRRRR\"\n";
  fs::remove(out_);
  expect_wrong_usage({"--all", "--config", config});
  fs::remove(config);
}

TEST_F(PatternCommandLine, TakesPaperAndLengthsAndPrintsTheConfiguration) {
  const std::string svg = written_by(
      {"--sheet", "a3", "--ring-radius-mm", "110", "--dot-diameter-mm", "35", "--centre-diameter-mm", "70.5"});
  EXPECT_TRUE(has(svg, "width=\"297mm\" height=\"420mm\""));
  EXPECT_TRUE(has(svg, "r=\"35.25\""));
  EXPECT_TRUE(has(printed_, "ring_radius_mm = 110\ndot_diameter_mm = 35\ncentre_diameter_mm = 70.5\n"));
}

TEST_F(PatternCommandLine, RefusesSeveralPagesInAnSvg) { expect_wrong_usage({"--id", "1", "2"}); }

TEST_F(PatternCommandLine, RefusesWrongUsageAndWritesNothing) {
  use_pdf();
  const std::vector<std::vector<std::string>> wrong{{"--id", "161"},
                                                    {"--id", "1-161"},
                                                    {"--id", "1", "1"},
                                                    {"--id", "3-1"},
                                                    {"--id", "1-"},
                                                    {"--id", "1-2-3"},
                                                    {"--id", "one"},
                                                    {"--id", "99999999999"},
                                                    {"--id", "-1"},
                                                    {"--all", "--config", "nowhere.toml"},
                                                    {"--code", "KRGB"},
                                                    {"--code", ""},
                                                    {"--code", "KRKRKRKR"},
                                                    {"--sheet", "a9"},
                                                    {"--ring-radius-mm", "200"},
                                                    {"--ring-radius-mm", "-5"},
                                                    {"--dot-diameter-mm", "90"}};
  for (const auto& words : wrong) expect_wrong_usage(words);
  EXPECT_THROW(written_by({"--id", "1", "--code", "KRGBKKRB"}), CLI::ParseError);
  EXPECT_THROW(written_by({"--ring-radius-mm", "wide"}), CLI::ParseError);
  EXPECT_THROW(written_by({"--all"}), CLI::ParseError) << "of which configuration";
  EXPECT_THROW(written_by({"--config", "a.toml"}), CLI::ParseError);
  EXPECT_THROW(written_by({"--all", "--config", "a.toml", "--id", "1"}), CLI::ParseError);
  EXPECT_THROW(written_by({"--all", "--config", "a.toml", "--dot-diameter-mm", "9"}), CLI::ParseError);
  EXPECT_THROW(run({"pattern"}), CLI::ParseError) << "--out is required";
  EXPECT_THROW(run({"pattern", "--out", "landmark.png"}), StartupError);
  EXPECT_FALSE(fs::exists(out_));
}

/// A map with one landmark, turned out of upright about an axis of its own, as `ninedot map` writes it.
Config map_with(const Eigen::Vector3d& axis, double angle_deg) {
  MappedLandmark landmark{1, std::string(*known_code(1)), place_upright({1, 2, 1.5}, 0.5), true};
  landmark.T_world_landmark.rotation *= exp_so3(angle_deg * kRadPerDeg * axis);
  ConfigProblems problems;
  const std::string none;
  Config config = read_config_text(format_map({&landmark, 1}, {}, {&none, 1}), "map", problems);
  EXPECT_TRUE(problems.list.empty()) << problems.list.front().what;
  return config;
}

TEST(LandmarksOfMap, AreTiltedWhereTheyLeanOrAreRolledAndNotForBeingWrittenAsAQuaternion) {
  const auto heading = [](const Eigen::Vector3d& axis, double angle_deg) {
    return landmarks_of_map(map_with(axis, angle_deg)).at(0).heading_deg;
  };
  const Eigen::Vector3d across = Eigen::Vector3d::UnitX(), ahead = Eigen::Vector3d::UnitY();
  ASSERT_TRUE(heading(across, 0));
  EXPECT_NEAR(*heading(across, 0), 0.5 * kDegPerRad, 1e-3);
  EXPECT_TRUE(heading(across, -1));
  EXPECT_TRUE(heading(ahead, 1)) << "by eye";
  EXPECT_FALSE(heading(ahead, 15)) << "rolled in its own plane";
  EXPECT_FALSE(heading(across, 15)) << "leans";
  EXPECT_FALSE(heading(across, 90)) << "lies on a floor";
}

}  // namespace
}  // namespace ninedot
