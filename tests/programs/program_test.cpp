#include "programs/program.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "programs/startup_errors.h"

namespace ninedot {
namespace {

struct Ending {
  int status = 0;
  std::string said;
};

Ending ending_of(const std::function<void()>& work) {
  CLI::App app{"", "tool"};
  std::string name = "tool";
  std::array<char*, 2> words{name.data(), nullptr};
  testing::internal::CaptureStderr();
  const int status = run_program(app, 1, words.data(), work);
  return {status, testing::internal::GetCapturedStderr()};
}

TEST(RunProgram, ALineBreakInAPathMakesNoSecondLine) {
  const Ending ending = ending_of([] { throw StartupError(ExitStatus::kWorkFailed, "a\nb: no such recording"); });
  EXPECT_EQ(ending.said, "tool: a?b: no such recording\n");
  EXPECT_EQ(ending.status, 1);
  EXPECT_EQ(ending_of([] { throw std::runtime_error("a\nb"); }).said, "tool: a?b\n");
}

TEST(RunProgram, GivesEachOfSeveralErrorsALine) {
  const Ending ending = ending_of([] { throw StartupErrors({"t.toml:1: one", "t.toml:2: two"}); });
  EXPECT_EQ(ending.said, "tool: t.toml:1: one\ntool: t.toml:2: two\n");
  EXPECT_EQ(ending.status, 2);
}

std::string refusal_of(std::vector<std::string> words) {
  CLI::App app{"", "tool"};
  app.require_subcommand(1);
  app.add_subcommand("replay", "");
  CLI::App* const group = app.add_subcommand("calibrate", "");
  group->require_subcommand(1);
  group->add_subcommand("camera", "");
  words.insert(words.begin(), "tool");
  std::vector<char*> typed;
  for (std::string& word : words) typed.push_back(word.data());
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_program(app, static_cast<int>(typed.size()), typed.data()), 2);
  return testing::internal::GetCapturedStderr();
}

TEST(RunProgram, NamesACommandThatThereIsNot) {
  EXPECT_EQ(refusal_of({"repaly", "x"}), "tool: unknown command 'repaly'; did you mean 'replay'?: see 'tool --help'\n");
  EXPECT_EQ(refusal_of({"banana"}), "tool: unknown command 'banana': see 'tool --help'\n");
  EXPECT_EQ(refusal_of({"calibrate", "camra"}),
            "tool: unknown command 'camra'; did you mean 'camera'?: see 'tool calibrate --help'\n");
  EXPECT_EQ(refusal_of({"--quiet"}), "tool: unknown option '--quiet': see 'tool --help'\n");
  EXPECT_EQ(refusal_of({}), "tool: A subcommand is required: see 'tool --help'\n");
}

}  // namespace
}  // namespace ninedot
