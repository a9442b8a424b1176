// `ninedot pattern` as it is typed.
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "programs/commands/commands.h"

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

TEST_F(PatternCommandLine, TakesPaperAndLengthsAndPrintsTheConfiguration) {
  const std::string svg = written_by(
      {"--sheet", "a3", "--ring-radius-mm", "110", "--dot-diameter-mm", "35", "--centre-diameter-mm", "70.5"});
  EXPECT_TRUE(has(svg, "width=\"297mm\" height=\"420mm\""));
  EXPECT_TRUE(has(svg, "r=\"35.25\""));
  EXPECT_TRUE(has(printed_, "ring_radius_mm = 110\n  dot_diameter_mm = 35\n  centre_diameter_mm = 70.5\n"));
}

TEST_F(PatternCommandLine, RefusesWrongUsageAndWritesNothing) {
  const std::vector<std::vector<std::string>> wrong{{"--id", "6"},
                                                    {"--id", "-1"},
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
  EXPECT_THROW(run({"pattern"}), CLI::ParseError) << "--out is required";
  EXPECT_THROW(run({"pattern", "--out", "landmark.png"}), StartupError);
  EXPECT_FALSE(fs::exists(out_));
}

}  // namespace
}  // namespace ninedot
