#include "programs/web/aim_request.h"

#include <array>
#include <charconv>
#include <cmath>

#include "base/inline_vector.h"
#include "programs/web/viewers.h"

namespace ninedot {
namespace {

constexpr std::size_t kMostWords = 6;
// The clock counts from the machine's start: thirty years, far from where nanoseconds overflow.
constexpr std::int64_t kLatest_ms = 1'000'000'000'000;

/// Words with one space between them. More of them than fit: none at all.
InlineVector<std::string_view, kMostWords> words_of(std::string_view text) {
  InlineVector<std::string_view, kMostWords> words;
  for (;;) {
    const std::size_t end = text.find(' ');
    if (!words.try_push_back(text.substr(0, end))) return {};
    if (end == std::string_view::npos) return words;
    text.remove_prefix(end + 1);
  }
}

template <typename Number>
bool read_number(std::string_view word, Number& number) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc() && end == word.data() + word.size();
}

bool read_jog(std::span<const std::string_view> words, AimRequest& request) {
  std::int64_t seen_ms = 0;
  if (words.size() != 4 || !read_number(words[0], request.number) || !read_number(words[1], seen_ms) ||
      !read_number(words[2], request.rates.pan_deg_s) || !read_number(words[3], request.rates.tilt_deg_s))
    return false;
  request.seen = MonoTime(std::chrono::milliseconds(seen_ms));
  return seen_ms >= 0 && seen_ms <= kLatest_ms && std::isfinite(request.rates.pan_deg_s) &&
         std::isfinite(request.rates.tilt_deg_s);
}

}  // namespace

std::optional<AimRequest> parse_aim_request(std::string_view text) {
  const auto words = words_of(text);
  if (words.size() < 2 || !Viewers::is_name(words[1])) return std::nullopt;
  AimRequest request;
  request.viewer = words[1];
  if (words[0] == "jog") {
    if (!read_jog(words.span().subspan(2), request)) return std::nullopt;
    return request;
  }
  constexpr std::array<std::pair<std::string_view, AimVerb>, 3> kVerbs{
      {{"take", AimVerb::kTake}, {"give", AimVerb::kGive}, {"follow", AimVerb::kFollow}}};
  for (const auto& [word, verb] : kVerbs)
    if (words[0] == word && words.size() == 2) {
      request.verb = verb;
      return request;
    }
  return std::nullopt;
}

}  // namespace ninedot
