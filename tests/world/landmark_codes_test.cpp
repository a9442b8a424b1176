#include "world/landmark_codes.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

TEST(LandmarkCodes, KnowTheirNumbersAndTheNumbersTheirCodes) {
  for (int id = 0; id <= 5; ++id) EXPECT_EQ(known_id(known_code(id).value()), id);
  EXPECT_EQ(known_id("KKKKKKKK"), 0);
  EXPECT_EQ(known_id(""), 0);
  for (const int id : {-1, 6}) EXPECT_FALSE(known_code(id)) << id;
  for (const char* code : {"KKKKKKKR", "KRG", "XXXXXXXX"}) EXPECT_FALSE(known_id(code)) << code;
}

TEST(LandmarkCodes, OfTheDictionaryDifferFromEveryTurnOfThemselvesAndOfEachOther) {
  for (int a = 1; a <= 5; ++a) {
    EXPECT_TRUE(is_landmark_code(*known_code(a)));
    EXPECT_FALSE(find_own_turn(*known_code(a))) << a;
    for (int b = 1; b < a; ++b) EXPECT_FALSE(is_turn_of(*known_code(a), *known_code(b))) << a << " " << b;
  }
}

TEST(LandmarkCodes, AreEightLettersOfFour) {
  EXPECT_TRUE(is_landmark_code("KRGBKKRB"));
  for (const char* code : {"", "KRGBKKR", "KRGBKKRBK", "KRGBKKRY", "krgbkkrb"}) EXPECT_FALSE(is_landmark_code(code));
}

TEST(LandmarkCodes, TellByHowManyDotsATurnLeavesThemAsTheyAre) {
  EXPECT_EQ(find_own_turn("KRGBKRGB"), 4U);
  EXPECT_EQ(find_own_turn("KRKRKRKR"), 2U);
  EXPECT_EQ(find_own_turn("RRRRRRRR"), 1U);
  EXPECT_FALSE(find_own_turn("KRGBKKRB"));
  EXPECT_FALSE(find_own_turn("KKKKKKKK"));
  EXPECT_FALSE(find_own_turn(""));
}

TEST(LandmarkCodes, AreTurnsOfEachOtherByAnyNumberOfDots) {
  const std::string code = "KRGBKKRB";
  for (std::size_t turn = 0; turn < code.size(); ++turn)
    EXPECT_TRUE(is_turn_of(code, code.substr(turn) + code.substr(0, turn))) << turn;
  EXPECT_FALSE(is_turn_of(code, "KRGBKKBR"));
  EXPECT_FALSE(is_turn_of(code, "KRGB"));
}

}  // namespace
}  // namespace ninedot
