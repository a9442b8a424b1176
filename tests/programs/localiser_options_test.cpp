#include "programs/assembly/localiser_options.h"

#include <gtest/gtest.h>

#include <chrono>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

TEST(LocaliserOptions, ARowTimeIsToldOrNobodyKnowsIt) {
  Config config;
  EXPECT_FALSE(localiser_options(config).row_time);
  config.camera.row_time_us = 33.3;
  EXPECT_EQ(localiser_options(config).row_time, 33300ns);
  config.camera.row_time_us = 0;
  EXPECT_EQ(localiser_options(config).row_time, 0ns) << "a global shutter";
}

TEST(LocaliserOptions, ASimulatedCamerasRowsAreKnown) {
  Config config;
  config.camera.source = "simulated";
  EXPECT_EQ(localiser_options(config).row_time, 0ns);
}

TEST(LocaliserOptions, NeedPlacesWherePosesAreReportedInTheWorld) {
  Config config;
  EXPECT_TRUE(localiser_options(config).needs_place);
  config.outputs.pose = "camera_in_landmark";
  EXPECT_FALSE(localiser_options(config).needs_place);
  config.outputs.pose = "body_in_world";
  EXPECT_TRUE(localiser_options(config).needs_place);
}

}  // namespace
}  // namespace ninedot
