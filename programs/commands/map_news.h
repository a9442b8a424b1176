#pragma once
/// How `ninedot map` fares, for another program: a line of JSON for each piece of news. docs/world.md has the table.
#include <cstddef>
#include <string>
#include <vector>

#include "mapping/map_builder.h"
#include "programs/commands/json_news.h"
#include "programs/commands/map_start.h"

namespace ninedot {

/// How far the reading of pictures is.
struct MapReading {
  int look = 1;                                                      ///< at all pictures: the first or the second
  std::size_t recording = 0, recordings = 0, frame = 0, frames = 0;  ///< each one of so many, from 1 on
};

/// Threads: one caller.
class MapNews final : public JsonNews {
 public:
  using JsonNews::JsonNews;

  void reading(const MapReading& reading);
  /// \param lines  as map_findings has them \param out, plan  the files; plan is empty where there is none
  void done(const BuiltMap& map, const MapStart& start, const std::vector<std::string>& lines, const std::string& out,
            const std::string& plan);
};

}  // namespace ninedot
