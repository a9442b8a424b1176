#include "programs/service/status_led.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

std::string two_seconds(LedPattern pattern) {
  std::string picture;
  for (int i = 0; i < 20; ++i) picture += is_led_lit(pattern, MonoTime(1000s) + i * 100ms + 1ms) ? '#' : '.';
  return picture;
}

TEST(StatusLed, ShowsFourPatternsThatCanNotBeTakenForEachOther) {
  std::map<std::string, LedPattern> seen;
  for (const LedPattern pattern :
       {LedPattern::kTracking, LedPattern::kNoLandmark, LedPattern::kNoCamera, LedPattern::kFault})
    EXPECT_TRUE(seen.emplace(two_seconds(pattern), pattern).second);
  EXPECT_EQ(two_seconds(LedPattern::kTracking), std::string(20, '#'));
  EXPECT_EQ(two_seconds(LedPattern::kNoCamera), "#.#.................");
}

TEST(StatusLed, TellsWhatIsTheMatter) {
  Report report;
  EXPECT_EQ(led_pattern_of(report), LedPattern::kNoCamera) << "nothing has been seen yet";
  report.reason = Reason::kNone;
  EXPECT_EQ(led_pattern_of(report), LedPattern::kTracking);
  report.reason = Reason::kNoLandmark;
  EXPECT_EQ(led_pattern_of(report), LedPattern::kNoLandmark);
  report.reason = Reason::kCameraLost;
  EXPECT_EQ(led_pattern_of(report), LedPattern::kNoCamera);
  report.reason = Reason::kFrameSize;
  EXPECT_EQ(led_pattern_of(report), LedPattern::kFault);
  report.reason = Reason::kNone;
  report.head.failed = true;
  EXPECT_EQ(led_pattern_of(report), LedPattern::kFault);
}

}  // namespace
}  // namespace ninedot
