#pragma once
/// What both programs share: the command line is parsed, the work is done, and whatever goes wrong becomes one line on
/// standard error (each of StartupErrors one) and an exit status. That includes what was printed and did not arrive.
#include <functional>

namespace CLI {
class App;
}

namespace ninedot {

/// \param app  with all its options; its name starts the error line. `--version` is added.
/// \param work  done after parsing; may throw StartupError. May be empty where sub-commands do the work.
/// \return  the exit status
int run_program(CLI::App& app, int argc, char** argv, const std::function<void()>& work = {});

}  // namespace ninedot
