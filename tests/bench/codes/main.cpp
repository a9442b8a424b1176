// Finds the dictionary of firmware/world/landmark_codes.cpp: keeps its first codes, adds as many as it can that are
// four places from everything, then as many as it can that are three, and prints all of them as they stand there.
//
//     build/release/bin/codes [HOW MANY ARE KEPT]        16; about half a minute, the same result at every run
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "free_set.h"
#include "geometry/landmark.h"
#include "world/landmark_codes.h"

namespace ninedot::codes {
namespace {

// Sheets and recordings with these were in the world before the dictionary was.
constexpr int kKept = 16;
// Of distance 4 more than 11 beside those 16 don't exist (all sets of the 58 candidates were counted out); of distance
// 3 seven other searches, of 4e6 steps, found 131 to 133 more.
constexpr std::int64_t kSteps = 20'000'000;
constexpr std::uint64_t kSeed = 8;

/// Of all codes that are each other's turns the first one, in the order of the letters K R G B.
std::vector<std::string> codes_up_to_turns() {
  std::vector<std::string> found;
  for (unsigned number = 0; number < 1U << 2 * kRingDotCount; ++number) {
    std::string code;
    for (std::size_t dot = kRingDotCount; dot-- > 0;) code += "KRGB"[number >> 2 * dot & 3U];
    const auto rank = [](char letter) { return std::string_view("KRGB").find(letter); };
    bool is_first = true;
    for (std::size_t turn = 1; turn < kRingDotCount && is_first; ++turn)
      is_first = !std::ranges::lexicographical_compare(code.substr(turn) + code.substr(0, turn), code, {}, rank, rank);
    if (is_first) found.push_back(code);
  }
  return found;
}

bool is_far(const std::string& a, const std::string& b, int places) { return code_distance(a, b).places >= places; }

/// As many further codes as are found that are `places` from all codes, and from each other.
std::vector<std::string> further_codes(const std::vector<std::string>& codes, int places) {
  std::vector<std::string> candidates = codes_up_to_turns();
  std::erase_if(candidates, [&](const std::string& candidate) {
    return own_distance(candidate).places < places || !is_far(candidate, "", places) ||
           !std::ranges::all_of(codes, [&](const std::string& code) { return is_far(candidate, code, places); });
  });
  Graph graph(candidates.size());
  std::size_t resemblances = 0;
  for (std::size_t a = 0; a < candidates.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (!is_far(candidates[a], candidates[b], places)) {
        graph[a].push_back(static_cast<int>(b)), graph[b].push_back(static_cast<int>(a));
        ++resemblances;
      }
  std::vector<std::string> found;
  for (const int candidate : find_free_set(graph, kSteps, kSeed))
    found.push_back(candidates[static_cast<std::size_t>(candidate)]);
  fmt::print(stderr, "distance {}: of {} candidates with {} resemblances {}, {} with those before\n", places,
             candidates.size(), resemblances, found.size(), codes.size() + found.size());
  return found;
}

void print(const std::vector<std::string>& codes) {
  constexpr std::size_t kInARow = 9;
  for (std::size_t i = 0; i < codes.size(); ++i)
    fmt::print("{}\"{}\"{}", i % kInARow == 0 ? "    " : " ", codes[i],
               i + 1 == codes.size()        ? "};\n"
               : i % kInARow == kInARow - 1 ? ",\n"
                                            : ",");
}

void run(int kept) {
  std::vector<std::string> codes;
  for (int id = 1; id <= kept; ++id) codes.emplace_back(known_code(id).value());
  for (const int places : {4, 3})
    for (std::string& code : further_codes(codes, places)) codes.push_back(std::move(code));
  print(codes);
}

}  // namespace
}  // namespace ninedot::codes

int main(int count, char** words) {
  const int kept = count > 1 ? std::atoi(words[1]) : ninedot::codes::kKept;
  if (count > 2 || kept < 0 || kept > ninedot::kFarCodes) {
    std::fputs("usage: codes [HOW MANY ARE KEPT]\n", stderr);
    return 2;
  }
  ninedot::codes::run(kept);
}
