#pragma once
/// A line per picture, for other programs, and to put pages together out of several runs.
#include <filesystem>

#include "tests/bench/trust/tally.h"

namespace ninedot::bench {

inline constexpr const char* kCsvHeader =
    "kind,name,frame,shown,found,valid,wrong,beyond,nees,error_mm,turn_deg,error_over_bound,work_ms\n";

std::string csv_line(const Strip& strip, std::size_t frame, const Verdict& verdict);

/// Adds the pictures of a file. \return  false where it can't be read, or a line is not as `csv_line` writes it
bool add_csv(const std::filesystem::path& file, Tallies& tallies);

}  // namespace ninedot::bench
