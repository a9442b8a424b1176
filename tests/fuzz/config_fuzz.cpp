// A configuration is refused with one line that names a line, or is within its ranges; so is a map.
#include "base/contract.h"
#include "base/startup_error.h"
#include "config/config_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace ninedot;
  ConfigProblems problems, of_map;
  Config with_map;
  read_map_text({reinterpret_cast<const char*>(bytes), count}, "m.toml", with_map, of_map);
  EXPECTS(!of_map.list.empty() || !with_map.landmarks.empty());
  for (const ConfigProblem& problem : of_map.list) EXPECTS(problem_text("c.toml", problem).starts_with("m.toml:"));
  try {
    const Config config = parse_config({reinterpret_cast<const char*>(bytes), count}, "c.toml", problems);
    EXPECTS(config.camera.rate_hz >= 0.1 && config.camera.rate_hz <= 100000 && config.modbus_tcp.port > 0);
    EXPECTS(config.landmark.centre_diameter_mm > config.landmark.dot_diameter_mm);
  } catch (const StartupError& error) {
    const std::string line = error.what();
    EXPECTS(line.starts_with("c.toml:") && line.find('\n') == std::string::npos && line[7] >= '0' && line[7] <= '9');
  }
  return 0;
}
