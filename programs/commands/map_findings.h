#pragma once
/// What a person should know beside a map, in plain lines.
#include <span>
#include <string>
#include <vector>

#include "mapping/map_builder.h"
#include "programs/commands/map_start.h"

namespace ninedot {

/// Why nothing could be placed, in one line.
std::string why_no_map(const SeenLandmarks& seen, const MapStart& start);

/// \param recordings  as they were named, by RecordedSightings::recording
std::vector<std::string> map_findings(const BuiltMap& map, const MapStart& start, const SeenLandmarks& seen,
                                      std::span<const std::string> recordings);

/// "3 of 4 landmarks placed, from ..."
std::string map_summary(const BuiltMap& map, const MapStart& start);
/// Which picture would help most. Empty: none would.
std::string map_wish(const BuiltMap& map);

}  // namespace ninedot
