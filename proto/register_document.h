#pragma once
/// The register map in words, from the table: what `ninedot registers` prints and docs/registers.md holds.
#include <string>

namespace ninedot {

/// The whole page for people, docs/registers.md.
std::string register_map_markdown();

/// One line per register: address,name,words,type,step,unit,lowest,highest,access,meaning (RFC 4180 quoting).
std::string register_map_csv();

/// {"version", "registers": [{...}], "status_bits", "health_bits", "metrics", "reasons", "commands"} for programs.
std::string register_map_json();

}  // namespace ninedot
