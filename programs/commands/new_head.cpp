#include "programs/commands/new_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "base/startup_error.h"
#include "config/config_edit.h"

namespace ninedot {
namespace {

/// All that head_file_text writes.
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kKeys{{{"body", "tilt_axis_mm"},
                                                                              {"body", "camera_mm"},
                                                                              {"body", "camera_rpy_deg"},
                                                                              {"body", "pan_sigma_deg"},
                                                                              {"body", "tilt_sigma_deg"},
                                                                              {"pan_tilt.pan", "calibration"},
                                                                              {"pan_tilt.tilt", "calibration"}}};

}  // namespace

std::string with_head(const std::string& config_text, const std::string& config_path, const std::string& head_text,
                      const std::string& name) {
  const std::vector<KeyText> keys = keys_of(head_text, name);
  const auto refuse = [&](const std::string& what) {
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("{}: {}: is it a file of `ninedot calibrate pan-tilt`?", name, what));
  };
  if (keys.empty()) refuse("has nothing of a head in it");
  for (const KeyText& key : keys)
    if (std::ranges::find(kKeys, std::pair<std::string_view, std::string_view>(key.table, key.key)) == kKeys.end())
      refuse(fmt::format("'{}' of [{}] is nothing of a head's calibration", key.key, key.table));
  return with_keys(config_text, keys, config_path);
}

}  // namespace ninedot
