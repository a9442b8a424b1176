#include "world/landmark_codes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace ninedot {
namespace {

/// The sheet after a turn clockwise: P1 is where P(1 + dots) was.
std::string turned(const std::string& code, std::size_t dots) {
  return code.substr(code.size() - dots) + code.substr(0, code.size() - dots);
}

/// Letter by letter, by another way than the code under test.
int places_between(const std::string& a, const std::string& b) {
  int places = 0;
  for (std::size_t i = 0; i < 8; ++i) places += a[i] != b[i];
  return places;
}

std::string code_of(int id) { return std::string(known_code(id).value()); }

TEST(LandmarkCodes, KnowTheirNumbersAndTheNumbersTheirCodes) {
  for (int id = 0; id <= kKnownCodes; ++id) EXPECT_EQ(known_id(code_of(id)), id);
  EXPECT_EQ(known_id("KKKKKKKK"), 0);
  EXPECT_EQ(known_id(""), 0);
  for (const int id : {-1, kKnownCodes + 1}) EXPECT_FALSE(known_code(id)) << id;
  for (const char* code : {"KKKKKKKR", "KRG", "XXXXXXXX"}) EXPECT_FALSE(known_id(code)) << code;
}

TEST(LandmarkCodes, OfTheDictionaryDifferInFourOrThreePlacesAtEveryTurn) {
  for (int a = 1; a <= kKnownCodes; ++a) {
    const std::string code = code_of(a);
    ASSERT_TRUE(is_landmark_code(code)) << a;
    const int to_itself = a <= kFarCodes ? 4 : 3;
    EXPECT_GE(places_between(code, "KKKKKKKK"), to_itself) << a;
    for (std::size_t turn = 1; turn < 8; ++turn) EXPECT_GE(places_between(code, turned(code, turn)), to_itself) << a;
    for (int b = 1; b < a; ++b)
      for (std::size_t turn = 0; turn < 8; ++turn)
        EXPECT_GE(places_between(code, turned(code_of(b), turn)), to_itself) << a << " and " << b << " by " << turn;
  }
}

TEST(LandmarkCodes, OfSheetsThatWerePrintedBeforeStayAsTheyAre) {
  const std::vector<std::string> before{"KRGBKKRB", "RRGKBGKB", "KKGRRBGB", "RKBGGKRB", "BKKRGRGB", "BKGKGKGR",
                                        "BGRBKKBK", "BGGGKRGG", "BBGRBRBK", "BBBRKKKG", "BKRRGGRK", "BRGRRGGK",
                                        "BBKGBRGR", "BBRBBRKG", "BGRRRKGG", "BGKKGRKG"};
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(code_of(static_cast<int>(i) + 1), before[i]);
}

TEST(LandmarkCodes, AreEightLettersOfFour) {
  EXPECT_TRUE(is_landmark_code("KRGBKKRB"));
  for (const char* code : {"", "KRGBKKR", "KRGBKKRBK", "KRGBKKRY", "krgbkkrb"}) EXPECT_FALSE(is_landmark_code(code));
}

TEST(CodeDistance, IsTheLeastOverAllTurnsAndNamesTheTurn) {
  const std::vector<std::string> some{"KRGBKKRB", "KKKKKKKR", "RGRGBBBB", "RRRRRRRR", "KRKRKRKR", "BGGGKRGG"};
  for (const std::string& a : some)
    for (const std::string& b : some) {
      const CodeDistance found = code_distance(a, b);
      std::vector<int> places;
      for (std::size_t turn = 0; turn < 8; ++turn) places.push_back(places_between(a, turned(b, turn)));
      EXPECT_EQ(found.places, *std::ranges::min_element(places)) << a << " " << b;
      EXPECT_EQ(found.turn, std::ranges::min_element(places) - places.begin()) << a << " " << b;
      EXPECT_EQ(code_distance(b, a).places, found.places);
    }
}

TEST(CodeDistance, CountsTurnsClockwiseAsTheViewerSees) {
  EXPECT_EQ(code_distance("KRKKKKKK", "RKKKKKKK").turn, 1) << "what was P1 is where P2 was";
  EXPECT_EQ(code_distance("RKKKKKKK", "KRKKKKKK").turn, 7);
}

TEST(CodeDistance, TakesNoLettersForBlackAndWhite) {
  EXPECT_EQ(code_distance("KRKKGKKK", "").places, 2);
  EXPECT_EQ(code_distance("", "KKKKKKKK").places, 0);
}

TEST(OwnDistance, TellsByHowManyDotsATurnLeavesTheSheetAsItIs) {
  const auto expect = [](const char* code, int places, int turn) {
    EXPECT_EQ(own_distance(code).places, places) << code;
    EXPECT_EQ(own_distance(code).turn, turn) << code;
  };
  expect("KRGBKRGB", 0, 4);
  expect("KRKRKRKR", 0, 2);
  expect("RRRRRRRR", 0, 1);
  expect("KRGBKKRB", 4, 4);
  expect("KKKKKKKR", 2, 1);
  expect("", 0, 1);
}

TEST(OwnDistanceDeathTest, HasAContractForWhatIsNoCode) {
  EXPECT_DEATH(own_distance("KRGB"), "contract");
  EXPECT_DEATH(code_distance("KRGBKKRB", "KRGBKKRX"), "contract");
}

}  // namespace
}  // namespace ninedot
