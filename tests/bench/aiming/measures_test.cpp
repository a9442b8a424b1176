#include "tests/bench/aiming/measures.h"

#include <gtest/gtest.h>

#include "base/units.h"

namespace ninedot::bench {
namespace {

SimulationRow row(double t_s, double pan_deg, double command_deg = 0) {
  SimulationRow row;
  row.truth.t_s = t_s;
  row.truth.head.pan_rad = pan_deg * kRadPerDeg;
  row.truth.centre_error_rad = std::abs(pan_deg) * kRadPerDeg;
  row.truth.visible = std::abs(pan_deg) < 20;
  row.command.pan_rad = command_deg * kRadPerDeg;
  row.valid = row.truth.visible;
  return row;
}

// From 20 deg to 0, 2 deg beyond, back over 1.6 to rest.
const Rows kStep{row(0, 20),        row(0.1, 10),     row(0.2, 1),   row(0.3, -2),
                 row(0.4, -1.6, 1), row(0.5, 0.5, 1), row(0.6, 0, 2)};

TEST(AimingMeasures, TakeAStepApart) {
  EXPECT_DOUBLE_EQ(settled_s(kStep, 1.5).value(), 0.5) << "at 0.2 s it was within for a moment only";
  EXPECT_EQ(settled_s(kStep, 0.0).value(), 0.6);
  EXPECT_FALSE(settled_s({row(0, 3), row(1, 2)}, 1.5));
  EXPECT_NEAR(overshoot(kStep, 0), 0.1, 1e-12);
  EXPECT_NEAR(overshoot({row(0, -10), row(1, -1)}, 0), 0, 1e-12);
}

TEST(AimingMeasures, CountCommandsThatDiffer) {
  EXPECT_EQ(command_changes(kStep, 0), 2);
  EXPECT_EQ(command_changes(kStep, 0.45), 1);
}

TEST(AimingMeasures, MeanTheErrorsOfATime) {
  const CentreErrors errors = centre_errors(kStep, 0, 0.15);
  EXPECT_NEAR(errors.rms_deg, std::sqrt((400 + 100) / 2.0), 1e-9);
  EXPECT_NEAR(errors.largest_deg, 20, 1e-9);
  EXPECT_NEAR(errors.in_view, 0.5, 1e-9);
  EXPECT_EQ(first_valid_s(kStep, 0).value(), 0.1);
  EXPECT_FALSE(first_valid_s(kStep, 2));
  EXPECT_NEAR(row_at(kStep, 0.25).truth.t_s, 0.3, 1e-12);
}

}  // namespace
}  // namespace ninedot::bench
