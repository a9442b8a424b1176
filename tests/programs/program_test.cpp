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

}  // namespace
}  // namespace ninedot
