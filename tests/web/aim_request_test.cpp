#include "programs/web/aim_request.h"

#include <gtest/gtest.h>

#include <string>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

TEST(WebAimRequest, IsOneLineOfWords) {
  const auto jog = parse_aim_request("jog 0123456789abcdef 17 5000 -12.5 0.25");
  ASSERT_TRUE(jog);
  EXPECT_EQ(jog->verb, AimVerb::kJog);
  EXPECT_EQ(jog->viewer, "0123456789abcdef");
  EXPECT_EQ(jog->number, 17U);
  EXPECT_EQ(jog->seen, MonoTime{5s});
  EXPECT_EQ(jog->rates.pan_deg_s, -12.5);
  EXPECT_EQ(jog->rates.tilt_deg_s, 0.25);
  EXPECT_EQ(parse_aim_request("take 01234567")->verb, AimVerb::kTake);
  EXPECT_EQ(parse_aim_request("give 01234567")->verb, AimVerb::kGive);
  EXPECT_EQ(parse_aim_request("follow 01234567")->verb, AimVerb::kFollow);
}

TEST(WebAimRequest, IsNothingElse) {
  for (const char* text : {"",
                           " ",
                           "take",
                           "take ",
                           "take short",
                           "take 01234567 ",
                           " take 01234567",
                           "take  01234567",
                           "Take 01234567",
                           "take 01234567\n",
                           "take 0123456/",
                           "park 01234567",
                           "take 01234567 1",
                           "jog 01234567",
                           "jog 01234567 1 5000 1",
                           "jog 01234567 1 5000 1 1 1",
                           "jog 01234567 -1 5000 1 1",
                           "jog 01234567 4294967296 5000 1 1",
                           "jog 01234567 1 -1 1 1",
                           "jog 01234567 1 1000000000001 1 1",
                           "jog 01234567 1 99999999999999999999 1 1",
                           "jog 01234567 1 5000 nan 1",
                           "jog 01234567 1 5000 1 inf",
                           "jog 01234567 1 5000 1e999 1",
                           "jog 01234567 1 5000 1,5 1",
                           "jog 01234567 1 5000 1.5x 1",
                           "jog 01234567 1 5000 0x10 1",
                           "jog 01234567 1 5000  1",
                           "{\"viewer\":\"01234567\"}"})
    EXPECT_FALSE(parse_aim_request(text)) << text;
  EXPECT_FALSE(parse_aim_request(std::string_view("take 01234567\0", 14)));
  EXPECT_FALSE(parse_aim_request(std::string(10000, ' ')));
}

}  // namespace
}  // namespace ninedot
