// Which landmark a ring of letters is, when every place is as sure as the test says.
#include "colour/code_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/allocation_counter.h"
#include "tests/support/random.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

constexpr double kMostOdds = 0.01;  // of all but the chosen one: above it nothing is acted on

/// Each letter at odds of `odds` to 1 against every other one; '?' tells nothing.
DotColours ring_of(std::string_view letters, double odds = 1000) {
  DotColours colours;
  colours.has_colour = true;
  colours.log_colourless.fill(static_cast<float>(-std::log(odds)));
  for (std::size_t place = 0; place < kRingDotCount; ++place)
    for (std::size_t letter = 0; letter < kInkCount; ++letter)
      if (letters[place] != '?' && letters[place] != kInkLetters[letter])
        colours.log_likelihood[place][letter] = static_cast<float>(-std::log(odds));
  return colours;
}

/// The code as it is numbered by a pose whose P1 stands `turn` places before the code's.
std::string seen_from(std::string code, std::size_t turn) {
  std::rotate(code.begin(), code.end() - static_cast<std::ptrdiff_t>(turn), code.end());
  return code;
}

std::vector<MappedLandmark> landmarks_of(std::initializer_list<const char*> codes) {
  std::vector<MappedLandmark> landmarks;
  for (const char* const code : codes) landmarks.push_back({static_cast<std::uint16_t>(landmarks.size()), code, {}});
  return landmarks;
}

/// Different from each other, and from themselves, at all turns.
std::vector<MappedLandmark> random_landmarks(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<MappedLandmark> landmarks;
  while (landmarks.size() < count) {
    std::string code;
    for (std::size_t i = 0; i < kRingDotCount; ++i) code += kInkLetters[random.bits() % kInkCount];
    const bool known =
        std::ranges::any_of(landmarks, [&](const auto& other) { return code_distance(code, other.code).places == 0; });
    if (known || own_distance(code).places == 0) continue;
    landmarks.push_back({static_cast<std::uint16_t>(landmarks.size()), code, {}});
  }
  return landmarks;
}

TEST(CodeReader, FindsEveryKnownCodeAtEveryTurn) {
  const std::vector<MappedLandmark> landmarks =
      landmarks_of({"", "KRGBKKRB", "RRGKBGKB", "KKGRRBGB", "RKBGGKRB", "BKKRGRGB"});
  const CodeReader reader(landmarks);
  for (std::size_t i = 1; i < landmarks.size(); ++i)
    for (std::size_t turn = 0; turn < kRingDotCount; ++turn) {
      const CodeReading reading = reader.decode(ring_of(seen_from(landmarks[i].code, turn)));
      ASSERT_TRUE(reading.best);
      EXPECT_EQ(reading.best->landmark, i);
      EXPECT_EQ(reading.best->turn, turn);
      EXPECT_LT(reading.odds_of_others, 1e-4);
    }
}

TEST(CodeReader, TellsBlackAndWhiteWithoutATurn) {
  const CodeReading reading = CodeReader(landmarks_of({"KRGBKKRB", ""})).decode(ring_of("KKKKKKKK"));
  EXPECT_EQ(reading.best->landmark, 1U);
  EXPECT_EQ(reading.best->turn, 0U);
  EXPECT_LT(reading.odds_of_others, 1e-4);
}

TEST(CodeReader, NamesNobodyForACodeThatIsNotInTheMap) {
  const CodeReader reader(landmarks_of({"KRGBKKRB", "RRGKBGKB"}));
  const CodeReading reading = reader.decode(ring_of("KRGBKKRG"));
  EXPECT_EQ(reading.best->landmark, 0U) << "one letter off";
  EXPECT_GT(reading.odds_of_others, 10 * kMostOdds);
  EXPECT_GT(reading.odds_of_none, 10 * kMostOdds);
  EXPECT_GT(reader.evidence_against(0, 0, ring_of("KRGBKKRG")), 0.1);
  const CodeReading stranger = reader.decode(ring_of("GGGBRRBG"));
  EXPECT_GT(stranger.odds_of_none, 0.99);
}

TEST(CodeReader, NamesNobodyWhereOnlyAHiddenPlaceTellsTwoLandmarksApart) {
  const CodeReader reader(landmarks_of({"KRGBKKRB", "KRGBKKRG"}));
  const CodeReading reading = reader.decode(ring_of("KRGBKKR?"));
  EXPECT_NEAR(reading.odds_of_others, 0.5, 0.01);
  ASSERT_TRUE(reading.second);
  EXPECT_NE(reading.second->landmark, reading.best->landmark);
  EXPECT_NEAR(reading.second->odds, reading.best->odds, 1e-6);
}

TEST(CodeReader, ReadsACodeWithTwoHiddenPlacesInAMapOfSixteen) {
  const std::vector<MappedLandmark> landmarks = random_landmarks(16, 5);
  std::string ring = seen_from(landmarks[7].code, 3);
  ring[2] = ring[6] = '?';
  const CodeReading reading = CodeReader(landmarks).decode(ring_of(ring));
  EXPECT_EQ(reading.best->landmark, 7U);
  EXPECT_EQ(reading.best->turn, 3U);
  EXPECT_LE(reading.odds_of_others, kMostOdds);
}

// The posterior itself, by its definition: likelihood of each code at each turn, and of random letters.
TEST(CodeReader, GivesThePosteriorOfBayesRule) {
  const std::vector<MappedLandmark> landmarks = random_landmarks(50, 11);
  test::Random random(12);
  DotColours colours;
  colours.has_colour = true;
  colours.log_colourless.fill(-0.5F);
  for (auto& row : colours.log_likelihood)
    for (float& one : row) one = static_cast<float>(-random.uniform(0, 3));
  const TurnCosts costs{0, 1, 4, 9, 16, 9, 4, 1};
  double weight_sum = 0;
  for (const double cost : costs) weight_sum += std::exp(-cost / 2);
  double sum = 0, most = 0, random_letters = 1;
  for (const auto& row : colours.log_likelihood) {
    double mean = 0;
    for (const float one : row) mean += std::exp(static_cast<double>(one)) / 4;
    random_letters *= mean;
  }
  random_letters += std::exp(-0.5 * kRingDotCount);  // a picture without colours
  sum = 0.01 * random_letters;
  for (const MappedLandmark& landmark : landmarks)
    for (std::size_t turn = 0; turn < kRingDotCount; ++turn) {
      double log_likelihood = -costs[turn] / 2 - std::log(weight_sum);
      for (std::size_t i = 0; i < kRingDotCount; ++i) {
        const auto letter = std::ranges::find(kInkLetters, landmark.code[i]) - kInkLetters.begin();
        log_likelihood +=
            static_cast<double>(colours.log_likelihood[(i + turn) % kRingDotCount][static_cast<std::size_t>(letter)]);
      }
      const double odds = 0.99 / 50 * std::exp(log_likelihood);
      sum += odds, most = std::max(most, odds);
    }
  const CodeReading reading = CodeReader(landmarks).decode(colours, costs);
  double near_misses = 0;
  for (std::size_t i = 0; i < kRingDotCount; ++i) {
    const auto& row = colours.log_likelihood[(i + reading.best->turn) % kRingDotCount];
    const auto own = std::ranges::find(kInkLetters, landmarks[reading.best->landmark].code[i]) - kInkLetters.begin();
    for (std::size_t letter = 0; letter < kInkCount; ++letter)
      if (letter != static_cast<std::size_t>(own))
        near_misses +=
            0.003 / 24 * most * std::exp(static_cast<double>(row[letter] - row[static_cast<std::size_t>(own)]));
  }
  sum += near_misses;
  EXPECT_NEAR(reading.best->odds, most / sum, 1e-5);
  EXPECT_NEAR(reading.odds_of_none, (0.01 * random_letters + near_misses) / sum, 1e-5);
  EXPECT_NEAR(reading.odds_of_others, 1 - most / sum, 1e-5);
}

TEST(CodeReader, KnowsNothingOfAGreyPicture) {
  const CodeReader reader(landmarks_of({"KRGBKKRB", ""}));
  const CodeReading reading = reader.decode({});
  EXPECT_FALSE(reading.best);
  EXPECT_EQ(reading.odds_of_others, 1);
  EXPECT_NEAR(reader.evidence_against(0, 0, {}), 1, 1e-6);
}

TEST(CodeReader, NamesNobodyInAPictureThatMayHaveLostItsColours) {
  const CodeReader reader(landmarks_of({"KRGBKKRB", "", "RRGKBGKB"}));
  DotColours colours = ring_of("KKKKKKKK");
  EXPECT_EQ(reader.decode(colours).best->landmark, 1U);
  EXPECT_GT(reader.evidence_against(0, 0, colours), 1e6);
  colours.log_colourless.fill(0);
  EXPECT_GT(reader.decode(colours).odds_of_others, kMostOdds);
  EXPECT_LT(reader.evidence_against(0, 0, colours), 2) << "a known landmark is not given up for that";
}

TEST(CodeReader, WatchesAKnownLandmark) {
  const std::vector<MappedLandmark> landmarks = landmarks_of({"KRGBKKRB", ""});
  const CodeReader reader(landmarks);
  EXPECT_LT(reader.evidence_against(0, 0, ring_of("KRGBKKRB")), 1e-4);
  EXPECT_LT(reader.evidence_against(0, 3, ring_of(seen_from("KRGBKKRB", 3))), 1e-4);
  EXPECT_LT(reader.evidence_against(0, 0, ring_of("KR?BK??B")), kMostOdds);
  EXPECT_GT(reader.evidence_against(0, 0, ring_of("KGGBRKRB")), 10);
  EXPECT_LT(reader.evidence_against(1, 0, ring_of("KKKKKKKK")), 1e-4);
  EXPECT_GT(reader.evidence_against(1, 0, ring_of("KRGBKKRB")), 1000);
}

TEST(CodeReader, DecodesAThousandCodesWithoutTheHeap) {
  const std::vector<MappedLandmark> landmarks = random_landmarks(1000, 3);
  const CodeReader reader(landmarks);
  const DotColours colours = ring_of(seen_from(landmarks[421].code, 6), 10'000);
  const test::AllocationGuard guard;
  const CodeReading reading = reader.decode(colours);
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_EQ(reading.best->landmark, 421U);
  EXPECT_EQ(reading.best->turn, 6U);
  EXPECT_LE(reading.odds_of_others, kMostOdds);
}

}  // namespace
}  // namespace ninedot
