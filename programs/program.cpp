#include "programs/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "base/one_line.h"
#include "base/startup_error.h"
#include "base/suggestion.h"
#include "programs/startup_errors.h"

namespace ninedot {
namespace {

constexpr std::string_view kOutputFailure = "standard output can't be written: is the disk full, or its reader gone?";

/// "ninedot calibrate camera": as far as the command line was understood.
std::string command_of(const CLI::App& app) {
  std::string command = app.get_name();
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) {
    at = at->get_subcommands().front();
    command += " " + at->get_name();
  }
  return command;
}

/// As CLI11 has it, but for a command that there is not: it says that one is missing, of a word that is there.
std::string mistake_of(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  const std::vector<std::string> unknown = at->remaining();
  if (at->get_require_subcommand_min() == 0 || unknown.empty()) return error.what();
  Suggestion suggestion(unknown.front());
  const std::vector<const CLI::App*> commands = at->get_subcommands([](const CLI::App*) { return true; });
  for (const CLI::App* known : commands) suggestion.consider(known->get_name());
  return fmt::format("unknown {} '{}'{}", unknown.front().starts_with('-') ? "option" : "command", unknown.front(),
                     suggestion.text());
}

}  // namespace

int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& work) {
  const std::string name = app.get_name();
  const auto failed = [&](std::string_view line, ExitStatus status) {
    // Where nobody takes it, the status says it.
    std::fputs(fmt::format("{}: {}\n", name, one_line(std::string(line))).c_str(), stderr);
    return static_cast<int>(status);
  };
  // What was printed may still be on its way.
  const auto finish = [&](ExitStatus status) {
    std::cout.flush();
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return static_cast<int>(status);
    return failed(kOutputFailure, ExitStatus::kWorkFailed);
  };
  app.set_version_flag("--version", name + " " NINEDOT_VERSION, "print the version and exit");
  try {
    app.parse(argc, argv);
    if (work) work();
    return finish(ExitStatus::kSuccess);
  } catch (const CLI::Success& help_or_version) {
    return finish(static_cast<ExitStatus>(app.exit(help_or_version)));
  } catch (const CLI::ParseError& error) {
    return failed(mistake_of(app, error) + ": see '" + command_of(app) + " --help'", ExitStatus::kWrongUsage);
  } catch (const StartupErrors& errors) {
    for (std::string_view lines = errors.what(); !lines.empty();) {
      const std::string_view line = lines.substr(0, lines.find('\n'));
      failed(line, errors.status);
      lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    }
    return static_cast<int>(errors.status);
  } catch (const StartupError& error) {
    return failed(error.what(), error.status);
  } catch (const std::exception& error) {
    // {fmt} throws where it prints and can't.
    return failed(std::ferror(stdout) != 0 ? kOutputFailure : error.what(), ExitStatus::kWorkFailed);
  }
}

}  // namespace ninedot
