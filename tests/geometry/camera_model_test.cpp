#include "geometry/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace ninedot {
namespace {

struct NamedLens {
  const char* name;
  CameraModel camera;
};

CameraModel make_camera(DistortionModel model, std::array<double, 8> k, double f_px = 720) {
  CameraModel camera;
  camera.fx_px = f_px;
  camera.fy_px = f_px * 1.01;
  camera.cx_px = 322.5;
  camera.cy_px = 237.25;
  camera.model = model;
  camera.k = k;
  return camera;
}

/// Lenses whose valid field covers the whole picture, from none to strong.
std::vector<NamedLens> lenses() {
  return {
      {"none", make_camera(DistortionModel::kPlumbBob, {})},
      {"weak barrel", make_camera(DistortionModel::kPlumbBob, {-0.28, 0.11, 0.0008, -0.0005, -0.02})},
      {"strong barrel", make_camera(DistortionModel::kPlumbBob, {-0.42, 0.22, 0.0015, -0.002, -0.05}, 470)},
      {"pincushion", make_camera(DistortionModel::kPlumbBob, {0.35, 0.2, -0.002, 0.003, 0.05}, 500)},
      {"moustache", make_camera(DistortionModel::kPlumbBob, {-0.3, 0.5, 0.001, 0.001, -0.1}, 600)},
      {"rational",
       make_camera(DistortionModel::kRationalPolynomial, {0.5, 0.1, 0.0005, -0.0004, 0.01, 0.9, 0.25, 0.03}, 400)},
      {"ideal fisheye", make_camera(DistortionModel::kEquidistant, {}, 300)},
      {"wide fisheye", make_camera(DistortionModel::kEquidistant, {-0.02, 0.01, -0.005, 0.0008}, 290)},
  };
}

TEST(CameraModel, UnprojectThenProjectIsTheIdentityOverTheWholePicture) {
  for (const NamedLens& lens : lenses()) {
    SCOPED_TRACE(lens.name);
    for (int v = 0; v < lens.camera.height_px; v += 13) {
      for (int u = 0; u < lens.camera.width_px; u += 13) {
        const Eigen::Vector2d pixel(u, v);
        const auto point = lens.camera.normalised_from_pixel(pixel);
        ASSERT_TRUE(point.has_value()) << pixel.transpose();
        ASSERT_LT((lens.camera.pixel_from_normalised(*point) - pixel).norm(), 1e-7) << pixel.transpose();
      }
    }
  }
}

TEST(CameraModel, ProjectThenUnprojectIsTheIdentity) {
  std::mt19937 random(std::hash<std::string>{}("ProjectThenUnprojectIsTheIdentity"));
  std::uniform_real_distribution<double> radius(0, 0.45), angle(-M_PI, M_PI);
  for (const NamedLens& lens : lenses()) {
    SCOPED_TRACE(lens.name);
    for (int i = 0; i < 500; ++i) {
      const double r = radius(random), a = angle(random);
      const Eigen::Vector2d point(r * std::cos(a), r * std::sin(a));
      const auto back = lens.camera.normalised_from_pixel(lens.camera.pixel_from_normalised(point));
      ASSERT_TRUE(back.has_value()) << point.transpose();
      ASSERT_LT((*back - point).norm(), 1e-9) << point.transpose();
    }
  }
}

TEST(CameraModel, JacobianEqualsCentralDifferences) {
  std::mt19937 random(std::hash<std::string>{}("JacobianEqualsCentralDifferences"));
  std::uniform_real_distribution<double> coordinate(-0.5, 0.5);
  constexpr double kStep = 1e-6;
  for (const NamedLens& lens : lenses()) {
    SCOPED_TRACE(lens.name);
    for (int i = 0; i < 200; ++i) {
      Eigen::Vector2d point(coordinate(random), coordinate(random));
      if (i == 0) point.setZero();
      if (i == 1) point = Eigen::Vector2d(3e-5, -6e-5);  // the fisheye's series
      Eigen::Matrix2d jacobian, differences;
      lens.camera.pixel_from_normalised(point, &jacobian);
      for (int c = 0; c < 2; ++c) {
        const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(c);
        differences.col(c) =
            (lens.camera.pixel_from_normalised(point + step) - lens.camera.pixel_from_normalised(point - step)) /
            (2 * kStep);
      }
      ASSERT_LT((jacobian - differences).norm(), 1e-5) << point.transpose() << "\n" << jacobian << "\n" << differences;
    }
  }
}

// cv::projectPoints and cv::fisheye::projectPoints of OpenCV 4.6, twelve digits.
TEST(CameraModel, ProjectsLikeOpenCv) {
  const std::array<Eigen::Vector2d, 3> points{Eigen::Vector2d(0.31, -0.22), Eigen::Vector2d(-0.4, 0.3),
                                              Eigen::Vector2d(0.05, 0.02)};
  struct Case {
    DistortionModel model;
    std::array<double, 8> k;
    std::array<Eigen::Vector2d, 3> pixels;
  };
  const std::array<Case, 3> cases{{
      {DistortionModel::kPlumbBob,
       {-0.31, 0.12, 0.0011, -0.0007, -0.021},
       {Eigen::Vector2d(532.163872199353, 90.476268926056), Eigen::Vector2d(49.468342375000, 442.810988078125),
        Eigen::Vector2d(354.290202368414, 256.124002792474)}},
      {DistortionModel::kRationalPolynomial,
       {-0.31, 0.12, 0.0011, -0.0007, -0.021, 0.05, 0.04, -0.01},
       {Eigen::Vector2d(530.457602287599, 91.683393954497), Eigen::Vector2d(53.392717093534, 439.876885670323),
        Eigen::Vector2d(354.284964835955, 256.121914312795)}},
      {DistortionModel::kEquidistant,
       {-0.012, 0.021, -0.008, 0.0013},
       {Eigen::Vector2d(531.724982639709, 90.724073377621), Eigen::Vector2d(51.083770846326, 441.499802826175),
        Eigen::Vector2d(354.288942607140, 256.120622020893)}},
  }};
  for (const Case& expected : cases) {
    CameraModel camera;
    camera.fx_px = 721.5, camera.fy_px = 719.25, camera.cx_px = 318.25, camera.cy_px = 241.75;
    camera.model = expected.model;
    camera.k = expected.k;
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_LT((camera.pixel_from_normalised(points[i]) - expected.pixels[i]).norm(), 1e-9);
  }
}

TEST(CameraModel, RefusesPixelsBeyondTheTurningPointOfABarrelLens) {
  // r (1 - 0.4 r^2) rises up to r = 0.9129, where it is 0.6086: 438 px from the centre at f = 720.
  const CameraModel camera = make_camera(DistortionModel::kPlumbBob, {-0.4});
  ASSERT_TRUE(camera.normalised_from_pixel({camera.cx_px + 0.608 * 720, camera.cy_px}).has_value());
  const auto beyond = camera.normalised_from_pixel({camera.cx_px + 0.609 * 720, camera.cy_px});
  ASSERT_FALSE(beyond.has_value());
  EXPECT_EQ(beyond.error().code, Errc::kPoseDegenerate);
}

TEST(CameraModel, RefusesTheSecondBranchOfALensFunctionThatRisesAgain) {
  // r (1 - 0.9 r^2 + 0.3 r^4) falls between r = 0.707 and r = 1.155: values above 0.4419 have a source on the far
  // branch only.
  const CameraModel camera = make_camera(DistortionModel::kPlumbBob, {-0.9, 0.3});
  EXPECT_TRUE(camera.normalised_from_pixel({camera.cx_px + 0.44 * 720, camera.cy_px}).has_value());
  for (const double value : {0.45, 0.6, 1.0, 5.0})
    EXPECT_FALSE(camera.normalised_from_pixel({camera.cx_px + value * 720, camera.cy_px}).has_value()) << value;
}

TEST(CameraModel, RefusesFisheyeDirectionsOf90DegAndMore) {
  const CameraModel camera = make_camera(DistortionModel::kEquidistant, {}, 200);
  EXPECT_TRUE(camera.normalised_from_pixel({camera.cx_px + 200 * 1.57, camera.cy_px}).has_value());
  EXPECT_FALSE(camera.normalised_from_pixel({camera.cx_px + 200 * 1.571, camera.cy_px}).has_value());
  EXPECT_FALSE(camera.normalised_from_pixel({camera.cx_px + 200 * 3.0, camera.cy_px}).has_value());
}

TEST(CameraModel, RefusesPixelsThatAreNoNumbers) {
  for (const NamedLens& lens : lenses()) {
    EXPECT_FALSE(lens.camera.normalised_from_pixel({std::numeric_limits<double>::quiet_NaN(), 0}).has_value());
    EXPECT_FALSE(lens.camera.normalised_from_pixel({0, std::numeric_limits<double>::infinity()}).has_value());
  }
}

}  // namespace
}  // namespace ninedot
