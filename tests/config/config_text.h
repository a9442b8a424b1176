#pragma once
/// Configurations written down in tests.
#include <gtest/gtest.h>

#include <string>

#include "base/startup_error.h"
#include "config/config_checks.h"

namespace ninedot::test {

/// Throws StartupError(kWrongUsage) with the first thing that is wrong.
inline Config parse(const std::string& text) {
  ConfigProblems problems;
  return parse_config(text, "t.toml", problems);
}

/// "t.toml:LINE: what", or "no error".
inline std::string error_of(const std::string& text) {
  try {
    parse(text);
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    return error.what();
  }
  return "no error";
}

}  // namespace ninedot::test
