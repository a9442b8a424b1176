#pragma once
/// What the search of one picture may cost. Counted, never clocked, so that a recording gives the same answers on every
/// machine and at every load.
#include <algorithm>
#include <cstddef>

namespace ninedot {

/// Allowances for one picture; work takes from them. The pictures of a room take a tenth of each,
/// and a third of the pixels.
/// tests/bench/trust/slowest.sh counts what the worst pictures cost with these, in instructions (docs/trust.md).
struct WorkBudget {
  int regions = 2500;  ///< dark regions measured (blob_moments.h), about 3,400 instructions each, with finding them
  int guesses = 60;    ///< guesses tried on the blobs and looked up in the picture (hypothesis.h), about 80,000
  int second_guesses = 25;  ///< the same, kept back for find_more_landmarks
  /// Pixels fitted to outlines (outline_refiner.h), one per pixel and stage, about 430, and what it takes to collect
  /// them. A usual landmark takes 9,000; one that fills the picture is fitted to every second or third pixel instead.
  /// What comes of it is looked at once more, for the shape of its dots, which is not counted. Where shadows cross its
  /// dots, their edges are fitted with what is left (light_edge.h).
  int pixels = 34'000;
  /// Something was left out because an allowance was used up. The next picture's search begins with it.
  bool is_overdrawn = false;
};

/// What a search takes beyond a usual one comes off the pixels, so that no picture is slow for both. A landmark and its
/// mirror image are left to it in any case.
/// \param allowed, left  before and after the search \return  pixels [1]
constexpr int pixels_of_search(const WorkBudget& allowed, const WorkBudget& left) noexcept {
  constexpr int kOfRegion = 8, kOfGuess = 190, kUsual = 5'200, kLeast = 10'000;
  const int guesses = allowed.guesses - left.guesses + allowed.second_guesses - left.second_guesses;
  const int taken = kOfRegion * (allowed.regions - left.regions) + kOfGuess * guesses;
  return std::clamp(taken - kUsual, 0, std::max(allowed.pixels - kLeast, 0));
}

/// \param allowance  [1] one is taken from it \return  false: it is used up
constexpr bool take_one(int& allowance) noexcept {
  if (allowance <= 0) return false;
  --allowance;
  return true;
}

/// Lets use(half) take from half of an allowance: something comes after it that may be worth more.
/// \param allowance  [1] less afterwards
template <typename Use>
auto with_half(int& allowance, Use&& use) noexcept {
  int half = (allowance + 1) / 2;
  allowance -= half;
  auto result = use(half);
  allowance += half;
  return result;
}

/// Calls try_from(rank) for ranks 0 .. count - 1 from `begin_at` [1] on and around, until one says that it can't go on.
/// \return  how many it got through. Fewer than all: begin_at is the one to go on with next time, and never the one
/// that it was: what is too much for one picture's allowance would be tried for ever.
template <typename TryFrom>
std::size_t go_round(std::size_t count, std::size_t& begin_at, TryFrom&& try_from) noexcept {
  const std::size_t begin = begin_at < count ? begin_at : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t rank = begin + i < count ? begin + i : begin + i - count;
    if (try_from(rank)) continue;
    begin_at = i > 0 ? rank : rank + 1;
    return i;
  }
  begin_at = 0;
  return count;
}

}  // namespace ninedot
