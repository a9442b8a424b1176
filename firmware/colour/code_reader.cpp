// The likelihood of a code is the product of its eight letters'. Of four letters in a row there are 256 kinds: their
// products at all eight places are worked out once, so that a code at all its turns is eight products of two.
#include "colour/code_reader.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

// How often a ring that passes for a landmark is none of the map's: another plant's, or a new one. One in a hundred.
constexpr double kForeignShare = 0.01;
// A third as often it is one that differs from the map's in a single letter: a sheet that was misprinted, or another
// plant's from the same box. Without it a code that is read with one letter wrong, beyond doubt, would count as a
// spoilt dot.
constexpr double kNearMissShare = 0.003;

// As often a coarse picture has lost the colours of all dots, and every landmark looks black and white.
constexpr double kColourlessShare = 0.01;

constexpr std::size_t kFours = 256;
/// Likelihood of four letters, P1 lowest, beginning at each place.
using FourTable = std::array<std::array<float, kRingDotCount>, kFours>;
using Likelihoods = std::array<std::array<float, kInkCount>, kRingDotCount>;

std::uint8_t four_of(std::string_view letters) {
  std::uint8_t bits = 0;
  for (std::size_t i = 0; i < letters.size(); ++i) {
    const auto at = std::ranges::find(kInkLetters, letters[i]);
    bits = static_cast<std::uint8_t>(bits | (static_cast<unsigned>(at - kInkLetters.begin()) << (2 * i)));
  }
  return bits;
}

Likelihoods likelihoods_of(const DotColours& colours) noexcept {
  Likelihoods likelihoods;
  for (std::size_t place = 0; place < kRingDotCount; ++place)
    for (std::size_t letter = 0; letter < kInkCount; ++letter)
      likelihoods[place][letter] = std::exp(colours.log_likelihood[place][letter]);
  return likelihoods;
}

void fill(const Likelihoods& likelihoods, FourTable& table) noexcept {
  std::array<std::array<float, kRingDotCount>, 16> pairs;
  for (std::size_t pair = 0; pair < pairs.size(); ++pair)
    for (std::size_t place = 0; place < kRingDotCount; ++place)
      pairs[pair][place] = likelihoods[place][pair & 3U] * likelihoods[(place + 1) % kRingDotCount][pair >> 2U];
  for (std::size_t four = 0; four < kFours; ++four)
    for (std::size_t place = 0; place < kRingDotCount; ++place)
      table[four][place] = pairs[four & 15U][place] * pairs[four >> 4U][(place + 2) % kRingDotCount];
}

/// Of eight letters of which each is as likely as any other.
double likelihood_of_random(const Likelihoods& likelihoods) noexcept {
  double product = 1;
  for (const auto& letters : likelihoods) {
    double sum = 0;
    for (const float likelihood : letters) sum += static_cast<double>(likelihood);
    product *= sum / static_cast<double>(kInkCount);
  }
  return product;
}

/// Of any code in a picture that has lost its colours.
double likelihood_of_colourless(const DotColours& colours) noexcept {
  double log_sum = 0;
  for (const float one : colours.log_colourless) log_sum += static_cast<double>(one);
  return std::exp(log_sum);
}

/// Letter of a code's P(i + 1), as an index of kInkLetters.
constexpr std::size_t letter_at(std::uint8_t first, std::uint8_t last, std::size_t i) noexcept {
  return (i < 4 ? first >> (2 * i) : last >> (2 * (i - 4))) & 3U;
}

/// Mean likelihood of the 24 codes that differ from this one in one letter, in units of its own.
double likelihood_of_near_misses(const Likelihoods& likelihoods, std::uint8_t first, std::uint8_t last,
                                 std::size_t turn) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < kRingDotCount; ++i) {
    const auto& letters = likelihoods[(i + turn) % kRingDotCount];
    const auto own = static_cast<double>(letters[letter_at(first, last, i)]);
    for (const float likelihood : letters) sum += static_cast<double>(likelihood) / own;
  }
  return (sum - kRingDotCount) / (kRingDotCount * (kInkCount - 1));
}

/// Prior odds of the turns, which sum to one.
std::array<float, kRingDotCount> turn_weights(const TurnCosts& costs) noexcept {
  std::array<float, kRingDotCount> weights;
  const double least = *std::ranges::min_element(costs);
  double sum = 0;
  for (std::size_t turn = 0; turn < costs.size(); ++turn) {
    const double weight = std::exp(-0.5 * (costs[turn] - least));
    weights[turn] = static_cast<float>(weight);
    sum += weight;
  }
  for (float& weight : weights) weight /= static_cast<float>(sum);
  return weights;
}

/// The two likeliest so far. \param choice  odds not yet divided by their sum
void keep_best(const CodeChoice& choice, CodeReading& reading) noexcept {
  if (!reading.best || choice.odds > reading.best->odds) {
    reading.second = reading.best;
    reading.best = choice;
  } else if (!reading.second || choice.odds > reading.second->odds) {
    reading.second = choice;
  }
}

}  // namespace

CodeReader::CodeReader(std::span<const MappedLandmark> landmarks) {
  codes_.reserve(landmarks.size());
  for (const MappedLandmark& landmark : landmarks) {
    if (is_black_and_white(landmark.code)) {
      codes_.push_back({0, 0, true});
      continue;
    }
    EXPECTS(is_landmark_code(landmark.code));
    codes_.push_back({four_of(landmark.code.substr(0, 4)), four_of(landmark.code.substr(4)), false});
  }
}

CodeReading CodeReader::decode(const DotColours& colours, const TurnCosts& turn_costs) const noexcept {
  CodeReading reading;
  if (!colours.has_colour || codes_.empty()) return reading;
  const Likelihoods likelihoods = likelihoods_of(colours);
  FourTable table;
  fill(likelihoods, table);
  const std::array<float, kRingDotCount> weights = turn_weights(turn_costs);
  const double prior = (1 - kForeignShare) / static_cast<double>(codes_.size());
  const double none =
      kForeignShare * likelihood_of_random(likelihoods) + kColourlessShare * likelihood_of_colourless(colours);
  double sum = none;
  for (std::size_t i = 0; i < codes_.size(); ++i) {
    const auto& first = table[codes_[i].first];
    if (codes_[i].is_black) {
      const double odds = prior * static_cast<double>(first[0] * table[0][kRingDotCount / 2]);
      sum += odds;
      keep_best({i, 0, odds}, reading);
      continue;
    }
    const auto& last = table[codes_[i].last];
    std::array<float, kRingDotCount> odds;
    for (std::size_t turn = 0; turn < kRingDotCount; ++turn)
      odds[turn] = weights[turn] * first[turn] * last[(turn + kRingDotCount / 2) % kRingDotCount];
    float total = 0, most = 0;
    for (const float one : odds) total += one, most = std::max(most, one);
    sum += prior * static_cast<double>(total);
    if (reading.second && prior * static_cast<double>(most) <= reading.second->odds) continue;
    for (std::size_t turn = 0; turn < kRingDotCount; ++turn)
      keep_best({i, turn, prior * static_cast<double>(odds[turn])}, reading);
  }
  const Code& best = codes_[reading.best->landmark];
  const double near_misses = kNearMissShare * reading.best->odds *
                             likelihood_of_near_misses(likelihoods, best.first, best.last, reading.best->turn);
  sum += near_misses;
  reading.best->odds /= sum;
  if (reading.second) reading.second->odds /= sum;
  reading.odds_of_none = (none + near_misses) / sum;
  reading.odds_of_others = std::clamp(1 - reading.best->odds, 0.0, 1.0);
  return reading;
}

double CodeReader::evidence_against(std::size_t landmark, std::size_t turn, const DotColours& colours) const noexcept {
  EXPECTS(landmark < codes_.size() && turn < kRingDotCount);
  const Code& code = codes_[landmark];
  const Likelihoods likelihoods = likelihoods_of(colours);
  double own = 1;
  for (std::size_t i = 0; i < kRingDotCount; ++i)
    own *= static_cast<double>(likelihoods[(i + turn) % kRingDotCount][letter_at(code.first, code.last, i)]);
  const double others = (1 - kNearMissShare) * likelihood_of_random(likelihoods) +
                        kNearMissShare * own * likelihood_of_near_misses(likelihoods, code.first, code.last, turn);
  // A picture without colours would show this landmark as it would any other.
  const double colourless = kColourlessShare * likelihood_of_colourless(colours);
  return (others + colourless) / (own + colourless);
}

}  // namespace ninedot
