/// Whatever a configuration file holds: it is refused with "FILE:LINE: why" in one line, or it is a configuration.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "app/config_checks.h"
#include "base/contract.h"
#include "base/startup_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ninedot;
  ConfigProblems problems;
  try {
    const Config config =
        parse_config(std::string_view(reinterpret_cast<const char*>(bytes), size), "fuzz.toml", problems);
    check_config(config, problems);
  } catch (const StartupError& error) {
    const std::string_view line = error.what();
    EXPECTS(line.starts_with("fuzz.toml:") && error.status == ExitStatus::kWrongUsage);
  }
  return 0;
}
