#pragma once
/// A command of `ninedot` as it is typed, within the test's own process.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "base/startup_error.h"

namespace ninedot::test {

struct TypedOutcome {
  ExitStatus status = ExitStatus::kSuccess;
  std::string line;  ///< of the error
  std::string said;  ///< on stderr, while it worked
};

/// \param add  as of programs/commands/commands.h \throw CLI::ParseError  as the command line's own refusals
inline TypedOutcome type_command(void (*add)(CLI::App&), std::vector<std::string> words) {
  CLI::App app;
  add(app);
  std::ranges::reverse(words);  // as CLI11 takes them
  TypedOutcome outcome;
  testing::internal::CaptureStderr();
  try {
    app.parse(words);
  } catch (const StartupError& error) {
    outcome.status = error.status;
    outcome.line = error.what();
    EXPECT_EQ(outcome.line.find('\n'), std::string::npos) << outcome.line;
  } catch (...) {
    testing::internal::GetCapturedStderr();
    throw;
  }
  outcome.said = testing::internal::GetCapturedStderr();
  return outcome;
}

/// It was refused, with this status and a line in which `what` occurs.
inline void expect_refusal(const TypedOutcome& outcome, ExitStatus status, const std::string& what) {
  EXPECT_EQ(outcome.status, status) << outcome.line;
  EXPECT_NE(outcome.line.find(what), std::string::npos) << outcome.line;
}

}  // namespace ninedot::test
