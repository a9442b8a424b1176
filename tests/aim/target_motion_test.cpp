#include "aim/target_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Eigen::Vector3d;
constexpr MonoTime kStart{100s};
constexpr std::chrono::duration<double> kMemory{0.08};

Vector3d driving(double t_s) { return Vector3d(1.2 - 0.9 * t_s, 1.5 + 0.1 * t_s, 0.2); }
MonoTime at_ms(int ms) { return kStart + std::chrono::milliseconds(ms); }

TEST(TargetMotion, ForetellsAnEvenMotionExactlyAfterTwoSightsAndThroughGaps) {
  TargetMotion motion;
  EXPECT_FALSE(motion.is_known());
  for (const int ms : {0, 28, 57, 150, 160, 400}) {
    motion.add(at_ms(ms), driving(ms * 1e-3), kMemory);
    if (ms == 0) continue;
    EXPECT_LT((motion.at(at_ms(ms + 300)) - driving((ms + 300) * 1e-3)).norm(), 1e-12) << ms;
  }
  EXPECT_EQ(motion.seen_at(), at_ms(400));
}

TEST(TargetMotion, TakesTheGainsOfAFadingMemoryWhateverTheFrameRate) {
  // From rest, one sight off by 1: 1 - t^2 of it is the place's, (1 - t)^2 / dt the velocity's.
  for (const int ms : {8, 28, 100}) {
    TargetMotion motion;
    int now = 0;
    for (int i = 0; i < 400; ++i) motion.add(at_ms(now += ms), Vector3d::Zero(), kMemory);
    now += ms;
    motion.add(at_ms(now), Vector3d(1, 0, 0), kMemory);
    const double fading = std::exp(-ms * 1e-3 / kMemory.count());
    EXPECT_NEAR(motion.at(at_ms(now)).x(), 1 - fading * fading, 1e-6);
    EXPECT_NEAR(motion.at(at_ms(now + 1000)).x() - motion.at(at_ms(now)).x(), (1 - fading) * (1 - fading) / (ms * 1e-3),
                1e-6);
  }
}

TEST(TargetMotion, SmoothsNoiseOfThePlaceAndOfTheVelocity) {
  test::Random random(4);
  double place = 0, velocity = 0;
  constexpr int kSights = 4000;
  TargetMotion motion;
  for (int i = 0; i < kSights; ++i) {
    motion.add(at_ms(28 * i), Vector3d(random.normal(), 0, 0), kMemory);
    const double x = motion.at(at_ms(28 * i)).x(), v = motion.at(at_ms(28 * i + 1000)).x() - x;
    place += x * x / kSights, velocity += v * v / kSights;
  }
  // Of the expanding form: (1 - t)(1 + 4t + 5t^2) / (1 + t)^3 and 2 (1 - t)^3 / (1 + t)^3 / dt^2 (Zarchan & Musoff,
  // table 7.3).
  const double t = std::exp(-0.028 / kMemory.count());
  EXPECT_NEAR(place, (1 - t) * (1 + 4 * t + 5 * t * t) / std::pow(1 + t, 3), 0.08);
  EXPECT_NEAR(velocity, 2 * std::pow((1 - t) / (1 + t), 3) / (0.028 * 0.028), 2);
}

TEST(TargetMotion, IgnoresASightThatIsNoNews) {
  TargetMotion motion;
  motion.add(at_ms(0), driving(0), kMemory);
  motion.add(at_ms(28), driving(0.028), kMemory);
  motion.add(at_ms(28), Vector3d(9, 9, 9), kMemory);
  motion.add(at_ms(10), Vector3d(9, 9, 9), kMemory);
  EXPECT_LT((motion.at(at_ms(100)) - driving(0.1)).norm(), 1e-12);
}

TEST(TargetMotion, AnotherLandmarkMovesAsTheOneBeforeDid) {
  TargetMotion motion;
  for (const int ms : {0, 28, 57}) motion.add(at_ms(ms), driving(ms * 1e-3), kMemory);
  motion.change_to(at_ms(85), driving(0.085) + Vector3d(2, 0, 0));
  EXPECT_LT((motion.at(at_ms(185)) - driving(0.185) - Vector3d(2, 0, 0)).norm(), 1e-12);
}

TEST(TargetMotion, SightsOfNoTrustMoveNothingButTheFirstPlace) {
  TargetMotion motion;
  motion.add(at_ms(0), Vector3d(1, 0, 0), kMemory, 0);
  EXPECT_EQ(motion.at(at_ms(0)).x(), 1);
  motion.add(at_ms(28), Vector3d(5, 0, 0), kMemory, 0);
  EXPECT_EQ(motion.at(at_ms(500)).x(), 1);
}

}  // namespace
}  // namespace ninedot
