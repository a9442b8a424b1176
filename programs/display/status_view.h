#pragma once
/// The register map in words, for people: shared by `ninedot status` and the live display of `ninedotd`, so that both
/// show exactly what a controller reads.
#include <string>

#include "proto/register_codec.h"

namespace ninedot {

/// One line: pose, 1-sigma, dots, rate, latency, drops; or why there is no pose. No line feed, no escape codes.
std::string status_line(const RegisterReader& registers);

/// The same and the metrics (proto/metrics.h), as a table of at least eleven lines, each ended by a line feed, at most
/// 100 columns wide.
std::string status_table(const RegisterReader& registers);

/// One JSON object on one line: every register by its name in its unit (`null` where unknown; not those
/// whose scale is configured), `status` and `health_flags` as lists of names, and `reason_text`.
std::string status_json(const RegisterReader& registers);

/// A reader that knows the word order of float32, told from the commissioning register.
RegisterReader make_reader(const RegisterBlock& registers) noexcept;

}  // namespace ninedot
