#pragma once
/// Which landmark of the map a ring of colours is, by whole codes and all turns.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "colour/dot_colours.h"
#include "world/landmark_map.h"

namespace ninedot {

/// One explanation of a ring.
struct CodeChoice {
  std::size_t landmark = 0;  ///< index in the span that the reader was made of [1]
  /// By how many places the pose's numbering must be advanced so that the code's P1 is P1: its place now is `turn`.
  /// 0..7; 0 for black and white, of which colour tells no turn.
  std::size_t turn = 0;
  double odds = 0;  ///< posterior, 0..1
};

/// All that speaks against the best choice counts: other landmarks, other turns, and that it is none of the map's.
struct CodeReading {
  std::optional<CodeChoice> best, second;  ///< nothing: no colour is known
  double odds_of_others = 1;               ///< of all but `best` together, 0..1
  double odds_of_none = 1;                 ///< that part of it that is none of the map's
};

/// What is known of the turn before colour is looked at: squares of normal deviates of the camera's mount, as in
/// LandmarkObservation::numbering_chi2. 0 for all: nothing.
using TurnCosts = std::array<double, kRingDotCount>;

/// Memory: made at the start, nothing afterwards but 8 kB of stack. Threads: const is safe.
class CodeReader {
 public:
  /// \param landmarks  those that may be seen, with eight letters each or black and white (contract); every code and
  /// turn is as likely as any other before the picture is looked at
  explicit CodeReader(std::span<const MappedLandmark> landmarks);

  /// The posterior by Bayes's rule over all codes, all turns, a ring of random letters, a picture without colours,
  /// and the likeliest code with one letter changed. A place without colours counts for nothing; eight products of two
  /// for each code. \param turn_costs  where the pose comes from a track whose numbering is known: large for all turns
  /// but 0 [1]
  CodeReading decode(const DotColours& colours, const TurnCosts& turn_costs = {}) const noexcept;

  /// What a picture says against a landmark that is known already, for a fraction of the cost of `decode`.
  /// \param landmark  index in the span (contract) [1]
  /// \param turn  as in CodeChoice; 0 for a pose whose numbering is right [1]
  /// \return  [1] the likelihood of any other ring (random letters, or one letter changed) in units of this landmark's,
  /// > 0: the factor by which the odds against it change. Below 1: the picture agrees; 1: nothing is known
  double evidence_against(std::size_t landmark, std::size_t turn, const DotColours& colours) const noexcept;

 private:
  struct Code {
    std::uint8_t first = 0, last = 0;  ///< P1..P4 and P5..P8, two bits each, P1 and P5 lowest
    bool is_black = false;
  };
  std::vector<Code> codes_;
};

}  // namespace ninedot
