#include "geometry/landmark_faults.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

TEST(LandmarkFaults, AreNoneOfTheDefaultLandmark) {
  const LandmarkFaults faults = find_landmark_faults({});
  EXPECT_FALSE(faults.ring_dots_touch || faults.centre_touches_ring || faults.centre_not_largest);
}

TEST(LandmarkFaults, AreFoundWhereDotsTouchEachOther) {
  const LandmarkGeometry wide{0.08, 0.0307, 0.035};
  EXPECT_TRUE(find_landmark_faults(wide).ring_dots_touch);
  // As they lie: the distance of two neighbours.
  EXPECT_NEAR(find_landmark_faults(wide).dot_diameter_below, (wide.centre_m(0) - wide.centre_m(1)).norm(), 1e-12);
  EXPECT_FALSE(find_landmark_faults({0.08, 0.0306, 0.035}).ring_dots_touch);
}

TEST(LandmarkFaults, AreFoundWhereTheCentreTouchesTheRingOrIsNotTheLargest) {
  EXPECT_TRUE(find_landmark_faults({0.08, 0.01, 0.07}).centre_touches_ring);
  EXPECT_FALSE(find_landmark_faults({0.08, 0.01, 0.0699}).centre_touches_ring);
  EXPECT_TRUE(find_landmark_faults({0.08, 0.01, 0.01}).centre_not_largest);
  EXPECT_FALSE(find_landmark_faults({0.08, 0.01, 0.0101}).centre_not_largest);
}

}  // namespace
}  // namespace ninedot
