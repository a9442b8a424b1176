#include "programs/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>

#include "base/startup_error.h"

namespace ninedot {

int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& work) {
  const std::string name = app.get_name();
  const auto failed = [&](std::string_view lines, ExitStatus status) {
    while (!lines.empty()) {
      const std::string_view line = lines.substr(0, lines.find('\n'));
      std::fputs(fmt::format("{}: {}\n", name, line).c_str(), stderr);  // where nobody takes it, the status says it
      lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    }
    return static_cast<int>(status);
  };
  app.set_version_flag("--version", name + " " NINEDOT_VERSION, "print the version and exit");
  try {
    app.parse(argc, argv);
    if (work) work();
    return static_cast<int>(ExitStatus::kSuccess);
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    return failed(std::string(error.what()) + ": see '" + name + " --help'", ExitStatus::kWrongUsage);
  } catch (const StartupError& error) {
    return failed(error.what(), error.status);
  } catch (const std::exception& error) {
    return failed(error.what(), ExitStatus::kWorkFailed);
  }
}

}  // namespace ninedot
