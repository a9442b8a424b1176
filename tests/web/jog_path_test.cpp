#include "programs/web/jog_path.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

JogPath path() { return {{-60, 60, 30}, {-20, 30, 30}}; }

TEST(WebJogPath, AdvancesAsFastAsItIsAsked) {
  JogPath path = ninedot::path();
  path.stand({10, -5});
  EXPECT_EQ(path.set_point(), (HeadDegrees{10, -5}));
  for (int i = 0; i < 50; ++i) path.advance({10, -5}, path.set_point(), 20ms);
  EXPECT_NEAR(path.set_point().pan_deg, 20, 1e-9);
  EXPECT_NEAR(path.set_point().tilt_deg, -10, 1e-9);
}

TEST(WebJogPath, IsNeverFasterThanItMay) {
  JogPath path = ninedot::path();
  path.advance({1e300, -1e300}, {}, 20ms);
  EXPECT_NEAR(path.set_point().pan_deg, 0.6, 1e-9);
  EXPECT_NEAR(path.set_point().tilt_deg, -0.6, 1e-9);
}

TEST(WebJogPath, MakesNoLongerStepHoweverLateItComes) {
  JogPath path = ninedot::path();
  path.advance({10, 0}, {}, 10s);
  EXPECT_NEAR(path.set_point().pan_deg, 0.4, 1e-9);
  path.advance({10, 0}, {}, -1s);
  EXPECT_NEAR(path.set_point().pan_deg, 0.4, 1e-9);
}

TEST(WebJogPath, StaysWithinTheLimits) {
  JogPath path = ninedot::path();
  for (int i = 0; i < 500; ++i) path.advance({30, -30}, path.set_point(), 20ms);
  EXPECT_EQ(path.set_point(), (HeadDegrees{60, -20}));
  for (int i = 0; i < 500; ++i) path.advance({-30, 30}, path.set_point(), 20ms);
  EXPECT_EQ(path.set_point(), (HeadDegrees{-60, 30}));
  path.stand({170, -90});
  EXPECT_EQ(path.set_point(), (HeadDegrees{60, -20}));
}

TEST(WebJogPath, WaitsForAHeadThatDoesNotCome) {
  JogPath path = ninedot::path();
  for (int i = 0; i < 100; ++i) path.advance({10, -10}, {0, 0}, 20ms);
  EXPECT_NEAR(path.set_point().pan_deg, 3, 1e-9) << "a quarter of a second ahead, and its dead band";
  EXPECT_NEAR(path.set_point().tilt_deg, -3, 1e-9);
  path.advance({1, -1}, {0, 0}, 20ms);
  EXPECT_NEAR(path.set_point().pan_deg, 3, 1e-9) << "slower, it does not turn back";
  path.advance({-10, 0}, {0, 0}, 20ms);
  EXPECT_NEAR(path.set_point().pan_deg, 2.8, 1e-9) << "the other way it may";
}

TEST(WebJogPath, StandsWhereNothingIsAsked) {
  JogPath path = ninedot::path();
  path.stand({10, 10});
  EXPECT_EQ(path.advance({}, {-50, 50}, 20ms), (HeadDegrees{10, 10}));
}

}  // namespace
}  // namespace ninedot
