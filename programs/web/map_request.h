#pragma once
/// What a page may ask of the map's desk.
#include <optional>
#include <string_view>
#include <vector>

namespace ninedot {

/// As of which words and names `ninedot map` is to be started. Lifetime: as the text's.
struct MapRequest {
  std::string_view origin;                   ///< "measured", "map", or the id of a landmark
  bool with_new = false;                     ///< landmarks that the configuration does not have are looked for as well
  std::vector<std::string_view> recordings;  ///< is_recording_name, each once; one at least
};

/// \param text  "start ORIGIN NAME ...", or "start ORIGIN new NAME ...", with one space between them and not a
/// character more \return  nothing: it is none
std::optional<MapRequest> parse_map_request(std::string_view text);

}  // namespace ninedot
