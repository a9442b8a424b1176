#include "programs/web/map_request.h"

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "programs/web/recording_name.h"

namespace ninedot {
namespace {

bool is_origin(std::string_view word) {
  if (word == "measured" || word == "map") return true;
  std::uint16_t id = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
  return error == std::errc() && end == word.data() + word.size();
}

/// Up to the next space, which goes as well.
std::string_view take_word(std::string_view& text) {
  const std::string_view word = text.substr(0, text.find(' '));
  text.remove_prefix(std::min(text.size(), word.size() + 1));
  return word;
}

}  // namespace

std::optional<MapRequest> parse_map_request(std::string_view text) {
  if (text.ends_with(' ') || take_word(text) != "start") return std::nullopt;
  MapRequest request{take_word(text), false, {}};
  if (!is_origin(request.origin)) return std::nullopt;
  if (text.starts_with("new ")) request.with_new = take_word(text) == "new";
  while (!text.empty()) {
    const std::string_view name = take_word(text);
    if (!is_recording_name(name) || std::ranges::count(request.recordings, name) > 0) return std::nullopt;
    request.recordings.push_back(name);
  }
  return request.recordings.empty() ? std::nullopt : std::optional(std::move(request));
}

}  // namespace ninedot
