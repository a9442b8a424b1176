#pragma once
/// `ninedot map` for the page: a map out of recordings that the page holds.
#include <functional>
#include <string>
#include <string_view>

#include "config/config.h"
#include "programs/web/apply_request.h"
#include "programs/web/child_job.h"

namespace ninedot {

struct MapDeskOptions {
  std::string why_not;      ///< for people: why no map is built from here; empty: one may be
  std::string config_path;  ///< the service's
  std::string map;          ///< that it names; empty: none
  std::string folder;       ///< in which maps lie, each in a folder of its own
  bool has_token = false;   ///< of the page
  /// Of a recording that is over, by its name; empty: there is none.
  std::function<std::string(std::string_view name)> folder_of;
  /// The configuration's landmarks, for the page. \see landmarks_json
  std::function<std::string()> landmarks;
};

/// All but the two functions. \param has_token  without one nothing is begun
MapDeskOptions map_desk_options(const Config& config, const std::string& config_path, bool has_token);

/// Memory, threads: as ChildJob.
class MapDesk {
 public:
  /// \param job  at which maps are built \param request  both must outlive this
  MapDesk(MapDeskOptions options, ChildJob& job, ApplyRequest& request)
      : options_(std::move(options)), job_(job), request_(request) {}

  /// \param text  as parse_map_request has it; "cancel"; or "use NAME": that one is to take the place of the service's
  /// \return  its status also: 400 not understood, 404 no such recording, 409 not now, 500 it could not be begun
  DeskReply reply_to(std::string_view text);
  /// What there is, for a page that is shown. \see docs/world.md for the lines of the child in it
  std::string state_json() const;
  /// \param path  what follows /api/map/build/ : NAME/map.toml or NAME/plan.svg, to the last character
  /// \return  where it lies; empty: it is none of these
  std::string file_of(std::string_view path) const;

 private:
  DeskReply start(std::string_view text);
  DeskReply use(std::string_view name);
  DeskReply with_state(const DeskReply& reply) const;

  const MapDeskOptions options_;
  ChildJob& job_;
  ApplyRequest& request_;
};

}  // namespace ninedot
