#include "pose/ellipse_parameters.h"

#include <gtest/gtest.h>

#include "geometry/disc.h"
#include "tests/pose/ellipse_scene.h"

namespace ninedot {
namespace {

using namespace ellipse_scene;

View any_view(std::mt19937_64& random) {
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  return {number(0.3, 7), number(0.1, 80), number(-180, 180), number(-180, 180), number(-15, 15), number(-12, 12)};
}

TEST(EllipseParameters, PoseOfTheParametersOfAPoseIsThePose) {
  auto random = random_for("PoseOfTheParametersOfAPoseIsThePose");
  for (int run = 0; run < 1000; ++run) {
    const View view = any_view(random);
    const CameraInLandmark T = view.pose();
    const EllipseParameters p = ellipse_parameters(T, {}, {});
    const Eigen::Vector2d p9 = project_plane_point(T.inverse(), {0, 0});
    double best = 10;  // psi names a line; which end of it is meant, a roll of half a circle, is not in the parameters
    for (const double turn : {0.0, M_PI}) {
      const CameraInLandmark back =
          pose_from_parameters(p.swing_psi_rad + turn, p.tilt_phi_rad, p.pan_theta_rad, p.distance_m, p9);
      ASSERT_LT(position_error_m(back, T), 1e-9) << "run " << run;
      best = std::min(best, rotation_error_rad(back, T));
    }
    ASSERT_LT(best, 1e-6) << "run " << run;
  }
}

TEST(EllipseParameters, AreDistanceTiltAndDeviationOfTheView) {
  auto random = random_for("AreDistanceTiltAndDeviationOfTheView");
  for (int run = 0; run < 200; ++run) {
    View view = any_view(random);
    view.pitch_deg = 0;
    const EllipseParameters p = ellipse_parameters(view.pose(), {}, {});
    EXPECT_NEAR(p.distance_m, view.distance_m, 1e-12);
    EXPECT_NEAR(p.image_distance_m, view.distance_m + kUnitFocalLength_m, 1e-12);
    EXPECT_NEAR(p.tilt_phi_rad, view.tilt_deg * kRad, 1e-12);
    EXPECT_NEAR(p.deviation_rad, std::abs(view.yaw_deg) * kRad, 1e-7);
  }
}

TEST(EllipseParameters, SwingIsTheRollAndPanIsZeroToTheViewersLeft) {
  // At the viewer's left (X0) the sheet leans about its vertical axis, which an upright camera sees upright.
  const EllipseParameters left = ellipse_parameters(View{1, 30, 0, 0}.pose(), {}, {});
  EXPECT_NEAR(left.pan_theta_rad, 0, 1e-12);
  EXPECT_NEAR(left.swing_psi_rad, 0, 1e-12);
  const EllipseParameters right = ellipse_parameters(View{1, 30, 180, 0}.pose(), {}, {});
  EXPECT_NEAR(std::abs(right.pan_theta_rad), M_PI, 1e-12);
  EXPECT_NEAR(std::sin(right.swing_psi_rad), 0, 1e-12);
  // A camera rolled clockwise sees the sheet turned the other way.
  EXPECT_NEAR(ellipse_parameters(View{1, 30, 0, 20}.pose(), {}, {}).swing_psi_rad, -20 * kRad, 1e-12);
  // From below, the sheet leans about its horizontal axis.
  const EllipseParameters below = ellipse_parameters(View{1, 30, -90, 0}.pose(), {}, {});
  EXPECT_NEAR(below.pan_theta_rad, M_PI / 2, 1e-12);
  EXPECT_NEAR(std::abs(below.swing_psi_rad), M_PI / 2, 1e-9);
}

TEST(EllipseParameters, FrontalViewHasNoTiltAndItsSwingIsTheRoll) {
  const EllipseParameters p = ellipse_parameters(View{1, 0, 0, -15}.pose(), {}, {});
  EXPECT_NEAR(p.tilt_phi_rad, 0, 1e-12);
  EXPECT_EQ(p.pan_theta_rad, 0);
  EXPECT_NEAR(p.swing_psi_rad, 15 * kRad, 1e-12);
}

}  // namespace
}  // namespace ninedot
