/// A server for foreign clients: publishes the known report of tests/proto/known_report.h until standard input ends.
/// Usage: modbus_serve [--rtu DEVICE]; prints the TCP port on a line of its own.
#include <cstdio>
#include <cstring>
#include <exception>

#include "drivers/modbus/server.h"
#include "tests/proto/known_report.h"

int main(int argc, char** argv) {
  using namespace ninedot;
  test::WireBox reports;
  const MonoTime started_at = mono_now();
  reports.publish(test::known_report(started_at));
  reports.metrics = test::known_metrics();
  ModbusOptions options;
  options.allow_writes = true;
  options.codec.stale_after = std::chrono::hours(1);  // the report never changes
  options.tcp.emplace().port = 0;
  if (argc == 3 && std::strcmp(argv[1], "--rtu") == 0) options.rtu.emplace().device = argv[2];
  try {
    const ModbusServer server(reports, options);
    std::printf("%u\n", server.tcp_port());
    std::fflush(stdout);
    while (std::getchar() != EOF) {
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
