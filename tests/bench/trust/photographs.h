#pragma once
/// Windows of real photographs, none of which shows a landmark.
#include <filesystem>
#include <string_view>
#include <vector>

#include "tests/bench/trust/strip.h"

namespace ninedot::bench {

/// To tune by one half and hold the other one back.
enum class Half : std::uint8_t { kTune, kHeld, kBoth };

/// By a hash of the file's name; a picture and its dark, light or scaled twin are in the same half.
Half half_of(std::string_view file_name);

std::vector<Kind> photograph_kinds();

/// One job per photograph: its windows of the camera's size at full, half and quarter scale (areas averaged), 60 at
/// most, flat ones left out. What is smaller than a window lies on white.
/// \param folder  JPEG, PNG and PGM files, see photographs.sh
std::vector<Job> photograph_jobs(const std::filesystem::path& folder, Half half);

}  // namespace ninedot::bench
