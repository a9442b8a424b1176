/// `ninedot registers`: the register map, for people (md), spreadsheets (csv) and programs (json).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "programs/commands/commands.h"
#include "proto/register_document.h"

namespace ninedot {
namespace {

void print_registers(const std::string& format) {
  const std::string text = format == "csv"    ? register_map_csv()
                           : format == "json" ? register_map_json()
                                              : register_map_markdown();
  fmt::print("{}", text);
}

}  // namespace

void add_registers_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("registers", "Print the Modbus register map");
  const auto format = std::make_shared<std::string>("md");
  command->add_option("--format", *format, "md (default), csv or json")->check(CLI::IsMember({"md", "csv", "json"}));
  command->callback([format] { print_registers(*format); });
}

}  // namespace ninedot
