#pragma once
/// The only exception of the project: start-up can't go on. Thrown in drivers/ and programs/, caught once in `main`.
#include <stdexcept>
#include <string>

namespace ninedot {

/// Exit statuses of both programs.
enum class ExitStatus : int { kSuccess = 0, kWorkFailed = 1, kWrongUsage = 2 };

/// `what()` is one line that says what to do, or several that each do; `main` prints them to standard error and returns
/// `status`.
class StartupError : public std::runtime_error {
 public:
  StartupError(ExitStatus exit_status, const std::string& line) : std::runtime_error(line), status(exit_status) {}
  ExitStatus status;
};

}  // namespace ninedot
