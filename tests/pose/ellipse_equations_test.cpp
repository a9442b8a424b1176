// The founding paper's equations, one by one; numbers in brackets are Martin & Adan's (Pattern Recognition 45 (2012)
// 578-595).
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "geometry/disc.h"
#include "pose/ellipse_distance.h"
#include "pose/ellipse_parameters.h"
#include "pose/off_centre.h"
#include "pose/ring_ellipse.h"
#include "tests/pose/ellipse_scene.h"

namespace ninedot {
namespace {

using namespace ellipse_scene;

std::vector<Eigen::Vector2d> points_on_ellipse(const Eigen::Vector2d& centre, double a, double b, double psi_rad,
                                               int count, double first_rad = 0.2,
                                               double step_rad = 0.7853981633974483) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const double along = a * std::cos(first_rad + i * step_rad), across = b * std::sin(first_rad + i * step_rad);
    // (right, down) of x' along the major axis, psi from upwards to the right, and z' a quarter turn further.
    points.push_back(centre + Eigen::Vector2d(std::sin(psi_rad) * along + std::cos(psi_rad) * across,
                                              -std::cos(psi_rad) * along + std::sin(psi_rad) * across));
  }
  return points;
}

/// Ring middles as a centred camera (z = 1) sees them.
std::vector<Eigen::Vector2d> ring_middles(const CameraInLandmark& T, const LandmarkGeometry& landmark) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot)
    points.push_back(project_plane_point(T.inverse(), landmark.centre_m(dot)));
  return points;
}

TEST(RingEllipse, Equations11To19RecoverAnyEllipse) {
  auto random = random_for("Equations11To19RecoverAnyEllipse");
  std::uniform_real_distribution<double> unit(0, 1);
  for (int run = 0; run < 1000; ++run) {
    const Eigen::Vector2d centre(600 * unit(random), 400 * unit(random));
    const double a = 5 + 200 * unit(random), b = a * (0.1 + 0.85 * unit(random)), psi = (unit(random) - 0.5) * M_PI;
    const auto ellipse = fit_ring_ellipse(points_on_ellipse(centre, a, b, psi, 8));
    ASSERT_TRUE(ellipse.has_value()) << "run " << run;
    ASSERT_NEAR(ellipse->semi_major, a, 1e-8 * a) << "run " << run;
    ASSERT_NEAR(ellipse->semi_minor, b, 1e-8 * a) << "run " << run;
    ASSERT_LT((ellipse->centre - centre).norm(), 1e-8 * a) << "run " << run;
    ASSERT_NEAR(std::sin(ellipse->swing_psi_rad - psi), 0, 1e-7) << "run " << run;
  }
}

TEST(RingEllipse, FiveNeighbouringDotsAreEnough) {
  const Eigen::Vector2d centre(310, 250);
  const auto ellipse = fit_ring_ellipse(points_on_ellipse(centre, 80, 50, 0.6, 5));
  ASSERT_TRUE(ellipse.has_value());
  EXPECT_NEAR(ellipse->semi_major, 80, 1e-6);
  EXPECT_NEAR(ellipse->semi_minor, 50, 1e-6);
  EXPECT_NEAR(ellipse->swing_psi_rad, 0.6, 1e-7);
}

TEST(RingEllipse, SwingIs45DegWhereAEqualsC) {  // (15)
  for (const double sign : {-1.0, 1.0}) {
    const auto ellipse = fit_ring_ellipse(points_on_ellipse({0, 0}, 30, 20, sign * M_PI / 4, 8));
    ASSERT_TRUE(ellipse.has_value());
    EXPECT_NEAR(ellipse->swing_psi_rad, sign * M_PI / 4, 1e-9);
  }
}

TEST(RingEllipse, RefusesFewPointsCoincidingPointsAndHyperbolas) {
  EXPECT_EQ(fit_ring_ellipse(points_on_ellipse({0, 0}, 30, 20, 0, 4)).error().code, Errc::kPoseDegenerate);
  EXPECT_EQ(fit_ring_ellipse(std::vector<Eigen::Vector2d>(8, {3, 4})).error().code, Errc::kPoseDegenerate);
  std::vector<Eigen::Vector2d> hyperbola;
  for (const double t : {-1.5, -0.5, 0.5, 1.5})
    for (const double side : {-1.0, 1.0}) hyperbola.emplace_back(side * std::cosh(t), std::sinh(t));
  EXPECT_EQ(fit_ring_ellipse(hyperbola).error().code, Errc::kPoseDegenerate);
}

TEST(EllipseDistance, Equation3IsExactForAFrontalSheet) {
  // D = R f / a (3)
  const LandmarkGeometry landmark;
  for (const double distance_m : {0.3, 1.0, 4.4, 7.0}) {
    const auto ellipse = fit_ring_ellipse(ring_middles(View{distance_m, 0}.pose(), landmark));
    ASSERT_TRUE(ellipse.has_value());
    EXPECT_NEAR(landmark.ring_radius_m / ellipse->semi_major, distance_m, 1e-9);
  }
}

TEST(EllipseDistance, ExactRelationsHoldAtEveryTilt) {
  // a = R / sqrt(D^2 - R^2 sin^2 phi), b = a^2 D cos(phi) / R, and their inverse
  const LandmarkGeometry landmark;
  const double R = landmark.ring_radius_m;
  for (const double D : {0.2, 0.3, 1.0, 7.0}) {
    for (const double tilt_deg : {1.0, 20.0, 45.0, 75.0, 85.0}) {
      const double phi = tilt_deg * kRad;
      const auto ellipse = fit_ring_ellipse(ring_middles(View{D, tilt_deg, 33}.pose(), landmark));
      ASSERT_TRUE(ellipse.has_value());
      const double a = R / std::sqrt(D * D - R * R * std::sin(phi) * std::sin(phi));
      EXPECT_NEAR(ellipse->semi_major, a, 1e-10);
      EXPECT_NEAR(ellipse->semi_minor, a * a * D * std::cos(phi) / R, 1e-10);
      const DistanceTilt back = exact_distance_tilt(ellipse->semi_major, ellipse->semi_minor, R);
      EXPECT_NEAR(back.distance_m, D, 1e-8);
      EXPECT_NEAR(back.tilt_phi_rad, phi, 1e-6);
    }
  }
}

TEST(EllipseDistance, Equation20IsTheNearHalfAxisSeenFromP9) {
  // b = R f cos(phi) / (D - R sin(phi)) (20), measured from P9 towards the sheet's nearer side
  const LandmarkGeometry landmark;
  const double R = landmark.ring_radius_m;
  for (const double D : {0.3, 1.0, 4.0}) {
    for (const double tilt_deg : {10.0, 45.0, 75.0}) {
      const CameraInLandmark T = View{D, tilt_deg, 0}.pose();  // leans towards X0: P3 is nearest
      EXPECT_NEAR(project_plane_point(T.inverse(), landmark.centre_m(2)).norm(),
                  R * std::cos(tilt_deg * kRad) / (D - R * std::sin(tilt_deg * kRad)), 1e-12);
    }
  }
}

TEST(EllipseDistance, Equation21ApproachesTheTiltWithDistance) {
  // phi = acos(b / a) (21): the exact cosine is b / a sqrt(1 - (R sin(phi) / D)^2)
  for (const double D : {0.3, 1.0, 5.0}) {
    const double phi = 50 * kRad, share = 0.08 * std::sin(phi) / D;
    const auto ellipse = fit_ring_ellipse(ring_middles(View{D, 50, 120}.pose(), {}));
    ASSERT_TRUE(ellipse.has_value());
    const double found = tilt_from_axes_rad(ellipse->semi_major, ellipse->semi_minor);
    EXPECT_NEAR(std::cos(found), std::cos(phi) / std::sqrt(1 - share * share), 1e-9);
  }
  EXPECT_EQ(tilt_from_axes_rad(3, 3), 0);
}

TEST(EllipseDistance, Equation6TurnsPixelsIntoMillimetres) {
  // D' = f R / (a_s Kmm) + f (6): 5.4 mm lens, 0.0075 mm per pixel, ring of 80 mm seen with 57.6 px is 1 m away.
  const auto distance_mm = image_distance_mm(57.6, 80, {5.4, 0.0075, 0, 0, 0});
  ASSERT_TRUE(distance_mm.has_value());
  EXPECT_NEAR(*distance_mm, 1000 + 5.4, 1e-9);
}

TEST(EllipseDistance, Equations8To10SettleOnTheDistanceThatSatisfiesThem) {
  // D' = f R / (a_s (p1 + p2 D'^p3)) + f
  const double f = 5.4, R = 80, p1 = 0.0074, p2 = 2e-5, p3 = 0.35;
  for (const double image_mm : {305.0, 1005.4, 4400.0, 7000.0}) {
    const double F = p1 + p2 * std::pow(image_mm, p3);
    const auto found_mm = image_distance_mm(f * R / ((image_mm - f) * F), R, {f, 0.0075, p1, p2, p3});
    ASSERT_TRUE(found_mm.has_value());
    EXPECT_NEAR(*found_mm, image_mm, 1e-6);
  }
}

TEST(EllipseDistance, RefusesARefinementThatDoesNotSettle) {
  const auto negative = image_distance_mm(57.6, 80, {5.4, 0.0075, 0.001, -1e-5, 1});
  ASSERT_FALSE(negative.has_value());
  EXPECT_EQ(negative.error().code, Errc::kPoseDegenerate);
  EXPECT_FALSE(image_distance_mm(57.6, 80, {5.4, 0.0075, 1e-9, 7.5e-9, 2}).has_value());  // swings between two values
}

TEST(EllipseAngles, Table2GivesThePanFromEachOfP1P5P3AndP7) {
  // theta = atan(z1 / (x1 cos phi)) (22), P5 alike (23); theta = atan(-x3 cos phi / z3) (24), P7 alike (25); x', z'
  // from P9.
  const LandmarkGeometry landmark;
  for (const double tilt_deg : {15.0, 40.0, 70.0}) {
    for (double azimuth_deg = -170; azimuth_deg < 180; azimuth_deg += 20) {
      const CameraInLandmark T = View{1.2, tilt_deg, azimuth_deg, 25}.pose();
      const EllipseParameters truth = ellipse_parameters(T, {}, landmark);
      const double cosine = std::cos(truth.tilt_phi_rad);
      for (const std::size_t dot : {0u, 4u, 2u, 6u}) {
        const Eigen::Vector2d at =
            to_ellipse_axes(project_plane_point(T.inverse(), landmark.centre_m(dot)), truth.swing_psi_rad);
        const double theta =
            dot % 4 == 0 ? std::atan(at.y() / (at.x() * cosine)) : std::atan(-at.x() * cosine / at.y());
        EXPECT_NEAR(std::sin(theta - truth.pan_theta_rad), 0, 1e-9) << "P" << dot + 1 << " azimuth " << azimuth_deg;
      }
    }
  }
}

TEST(EllipseAngles, PerspectiveShiftsP9TowardsTheFartherSideOfTheMinorAxis) {
  // The paper's d1 and d2: the side on which P9 is nearer to the ellipse is the sheet's farther one.
  for (const bool viewer_left : {true, false}) {
    const CameraInLandmark T = View{0.8, 40, viewer_left ? 0.0 : 180.0}.pose();
    const auto ellipse = fit_ring_ellipse(ring_middles(T, {}));
    ASSERT_TRUE(ellipse.has_value());
    const double shift =
        -ellipse->centre.x();  // P9 is in the picture's middle; positive = to the right of the ellipse's centre
    EXPECT_GT(viewer_left ? shift : -shift, 0.001);
  }
}

TEST(OpticalAxis, Equation27GivesTheDeviation) {
  // tan(delta) = m / f (27)
  for (const double delta_deg : {0.0, 2.0, 15.0, 30.0}) {
    const CameraInLandmark T = View{2, 30, 40, 10, delta_deg, 0}.pose();
    const Eigen::Vector2d p9 = project_plane_point(T.inverse(), {0, 0});
    EXPECT_NEAR(deviation_rad(p9), delta_deg * kRad, 1e-12);
    EXPECT_NEAR(ellipse_parameters(T, {}, {}).deviation_rad, delta_deg * kRad, 1e-7);
  }
}

TEST(OpticalAxis, Equation28GivesTheHeadingFromX0) {
  // gamma = pi/2 - (phi - delta) (28): a camera at the sheet's height, to the viewer's left, turned right by delta.
  for (const double delta_deg : {-8.0, 0.0, 5.0}) {
    const CameraInLandmark T = View{2, 35, 0, 0, delta_deg, 0}.pose();
    const Eigen::Vector3d axis = -T.rotation.col(2);  // from the camera's target back to it
    EXPECT_NEAR(heading_gamma_rad(35 * kRad, -delta_deg * kRad), std::atan2(axis.y(), axis.x()), 1e-12);
  }
}

TEST(OpticalAxis, Equation30IsTheDistanceErrorOfTheUncentredPicture) {
  // a1 = a2 cos(delta) (29), so D errs by 1 - cos(delta) (30), where the major axis lies across the direction of the
  // offset.
  const LandmarkGeometry landmark;
  const double D = 5, phi = 60 * kRad, delta = 12 * kRad;
  const CameraInLandmark T = View{D, 60, 0, 0, 12, 0}.pose();
  const auto ellipse = fit_ring_ellipse(ring_middles(T, landmark));
  ASSERT_TRUE(ellipse.has_value());
  const double found = landmark.ring_radius_m / ellipse->semi_major;
  EXPECT_NEAR(1 - found / D, misalignment_distance_error(delta), 1e-3);
  EXPECT_GT(misalignment_distance_error(delta), 0.02);
  EXPECT_LT(std::abs(1 - exact_distance_tilt(ellipse->semi_major, ellipse->semi_minor, 0.08).distance_m / D), 0.03)
      << phi;
}

TEST(OffCentre, Equation36IsTheMatrixOf32And33) {
  // u' = (u - u9)(1 + cu u9^2 + cu u9^4) + u9 (32), v' alike with cv (33)
  const double cu = -3e-9, cv = 2e-9;
  const Eigen::Vector2d p9(70, -45), p(95, -80);
  const Eigen::Vector2d moved = (off_centre_correction(p9, cu, cv) * p.homogeneous()).hnormalized();
  const double u2 = p9.x() * p9.x(), v2 = p9.y() * p9.y();
  EXPECT_NEAR(moved.x(), (p.x() - p9.x()) * (1 + cu * u2 + cu * u2 * u2) + p9.x(), 1e-12);
  EXPECT_NEAR(moved.y(), (p.y() - p9.y()) * (1 + cv * v2 + cv * v2 * v2) + p9.y(), 1e-12);
  EXPECT_LT(((off_centre_correction(p9, cu, cv) * p9.homogeneous()).hnormalized() - p9).norm(), 1e-12);
}

TEST(Disc, CentreOfTheOutlineIsTheMeanOfAnEllipseThroughProjectedOutlinePoints) {
  const CameraInLandmark T = View{0.4, 55, 70, 20, 6, 3}.pose();
  const Eigen::Vector2d centre_m(0.03, -0.05);
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < 16; ++i)
    outline.push_back(project_plane_point(
        T.inverse(), centre_m + 0.02 * Eigen::Vector2d(std::cos(i * M_PI / 8), std::sin(i * M_PI / 8))));
  const auto ellipse = fit_ring_ellipse(outline);
  ASSERT_TRUE(ellipse.has_value());
  const Eigen::Vector2d predicted = project_disc_centre(T.inverse(), centre_m, 0.02);
  EXPECT_LT((predicted - ellipse->centre).norm(), 1e-10);
  EXPECT_GT((predicted - project_plane_point(T.inverse(), centre_m)).norm(), 5e-4);  // a third of a pixel and more
}

}  // namespace
}  // namespace ninedot
