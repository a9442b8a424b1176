// The renderer is the ruler of the accuracy tables: here it is held against geometry that can be written down.
#include "tests/support/renderer.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/random.h"
#include "tests/support/renderer_optics.h"

namespace ninedot::test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// One dot on endless paper, without noise, in linear light.
Scene single_dot(const Viewpoint& viewpoint, const Disc& disc) {
  Scene scene;
  scene.camera = look_at_landmark(viewpoint);
  scene.sheets = {Sheet{0, 0, 0, 0, 0, {disc}, {}}};
  scene.wall = {0.9, 0, 0.1, 1};
  scene.sensor.tone = ToneCurve::kLinear;
  return scene;
}

// Centroid of what is darker than the paper.
Eigen::Vector2d dark_centroid_px(const Exposure& exposure, double paper) {
  Eigen::Vector2d moment(0, 0);
  double sum = 0;
  for (int y = 0; y < exposure.height_px; ++y)
    for (int x = 0; x < exposure.width_px; ++x) {
      const double dark = paper - exposure.at(x, y);
      sum += dark;
      moment += dark * Eigen::Vector2d(x, y);
    }
  return moment / sum;
}

// Centre of the conic that a pinhole makes of a circle: Q = H diag(r^2, r^2, -1) H^T, c = (Q13, Q23) / Q33.
Eigen::Vector2d conic_centre_px(const Scene& scene, const Disc& disc) {
  const auto& c = scene.camera.position_m;
  const Eigen::Matrix3d R_camera_s0 = rotation_of(scene.camera).transpose();
  Eigen::Matrix3d H;
  H << R_camera_s0.col(0), R_camera_s0.col(2), R_camera_s0 * Eigen::Vector3d(disc.x_m - c[0], -c[1], disc.z_m - c[2]);
  Eigen::Matrix3d K;
  K << scene.lens.fx_px, 0, scene.lens.cx_px, 0, scene.lens.fy_px, scene.lens.cy_px, 0, 0, 1;
  const double r2 = disc.radius_m * disc.radius_m;
  const Eigen::Matrix3d Q = K * H * Eigen::Vector3d(r2, r2, -1).asDiagonal() * (K * H).transpose();
  return {Q(0, 2) / Q(2, 2), Q(1, 2) / Q(2, 2)};
}

TEST(Renderer, DiscCentroidsAgreeWithTheAnalyticConic) {
  for (const double distance_m : {0.4, 1.0, 3.0, 6.0})
    for (const double tilt_deg : {0.0, 30.0, 60.0}) {
      const Disc disc{0.03, -0.02, 0.0254};
      const Viewpoint viewpoint{distance_m, tilt_deg * kDegree, 0.7, 0.2, 0.08, -0.05};
      const Scene scene = single_dot(viewpoint, disc);
      const Eigen::Vector2d measured = dark_centroid_px(expose(scene), scene.light.level * 0.9);
      EXPECT_LT((measured - conic_centre_px(scene, disc)).norm(), 0.005)
          << distance_m << " m, " << tilt_deg << " deg: " << measured.transpose();
    }
}

TEST(Renderer, DiscCentroidsAgreeWithProjectedOutlinesThroughEveryLens) {
  const Disc disc{0.05, 0.06, 0.0254};
  Scene scene = single_dot({0.7, 0.5, -0.4, -0.3, 0.2, 0.12}, disc);
  const auto check = [&](const char* lens) {
    const Eigen::Vector2d measured = dark_centroid_px(expose(scene), scene.light.level * 0.9);
    EXPECT_LT((measured - centroid_of_disc_px(scene.lens, scene.camera, disc)).norm(), 0.005) << lens;
  };
  check("pinhole");
  scene.lens.k = {-0.12, 0.05, 0.0008, -0.0005};
  check("plumb_bob");
  scene.lens.model = LensModel::kRational;
  scene.lens.k = {0.3, -0.2, 0.0008, -0.0005, 0.01, 0.4, -0.1, 0.02};
  check("rational");
  scene.lens.model = LensModel::kEquidistant;
  scene.lens.k = {0.03, -0.01, 0.002, -0.0005};
  check("equidistant");
}

TEST(Renderer, RaysUndoTheProjectionOverTheWholePicture) {
  const CameraPose pose = look_at_landmark({1.2, 0.4, 2.0, 0.3, 0, 0});
  Lens lens;
  lens.k = {-0.12, 0.05, 0.0008, -0.0005};
  const Eigen::Matrix3d R = rotation_of(pose);
  for (int y = 0; y < lens.height_px; y += 48)
    for (int x = 0; x < lens.width_px; x += 64) {
      const Ray ray = ray_of_pixel(lens, x, y);
      ASSERT_TRUE(ray.valid);
      const Eigen::Vector3d direction = R * ray.direction;
      const double reach = -pose.position_m[1] / direction.y();
      const Eigen::Vector2d back = pixel_of_wall_point(lens, pose, pose.position_m[0] + reach * direction.x(),
                                                       pose.position_m[2] + reach * direction.z());
      EXPECT_LT((back - Eigen::Vector2d(x, y)).norm(), 1e-8);
    }
}

TEST(Renderer, ViewpointsPutTheLandmarkWhereTheySay) {
  const Viewpoint viewpoint{2.5, 35 * kDegree, 110 * kDegree, 0.3, 9 * kDegree, -6 * kDegree};
  const CameraPose pose = look_at_landmark(viewpoint);
  const Eigen::Vector3d centre(pose.position_m[0], pose.position_m[1], pose.position_m[2]);
  EXPECT_NEAR(centre.norm(), 2.5, 1e-12);
  EXPECT_NEAR(std::acos(centre.y() / centre.norm()), 35 * kDegree, 1e-12);
  const Lens lens;
  const Eigen::Vector2d p9 = pixel_of_wall_point(lens, pose, 0, 0);
  EXPECT_NEAR(p9.x(), lens.cx_px + lens.fx_px * std::tan(9 * kDegree), 1e-9);
  EXPECT_NEAR(p9.y(), lens.cy_px - lens.fy_px * std::tan(6 * kDegree), 1e-9);
}

TEST(Renderer, SeenFromTheFrontP1IsLowestAndP3IsLeft) {
  const CameraPose straight;  // the default
  const Lens lens;
  EXPECT_NEAR((pixel_of_wall_point(lens, straight, 0, -0.08) - Eigen::Vector2d(319.5, 239.5 + 57.6)).norm(), 0, 1e-9);
  EXPECT_NEAR((pixel_of_wall_point(lens, straight, 0.08, 0) - Eigen::Vector2d(319.5 - 57.6, 239.5)).norm(), 0, 1e-9);
}

TEST(Renderer, BoardHidesTheFractionAskedFor) {
  for (const double direction_rad : {0.0, 0.6, -2.5})
    for (const double fraction : {0.1, 0.5, 0.85}) {
      Scene scene;
      scene.sheets = {Sheet{}};
      scene.lens.fx_px = scene.lens.fy_px = 1800;
      scene.sensor.point_spread_px = 0;
      scene.board = {fraction, direction_rad, 1, 1, {0, 0, 0.1, 1}};
      scene.wall = {0, 0, 0.1, 1};
      double seen = 0;
      for (const double light : expose(scene).light) seen += light;
      const double sheet = std::pow(0.21 * 1800, 2) * scene.light.level * 0.9;
      EXPECT_NEAR(1 - seen / sheet, fraction, 0.002) << direction_rad;
    }
}

TEST(Renderer, AWallThatStandsOutEvenlyIsOneThatIsNearer) {
  Scene near = single_dot({.distance_m = 0.8, .tilt_rad = 40 * kDegree}, Disc{0.03, 0.02, 0.02, 0.04});
  Scene raised = near;
  near.camera.position_m[1] -= 0.01;
  raised.relief.waves = {Wave{}};
  raised.relief.offset_m = 0.01;
  const Exposure expected = expose(near), seen = expose(raised);
  for (std::size_t i = 0; i < seen.light.size(); ++i) ASSERT_NEAR(seen.light[i], expected.light[i], 1e-9);
}

TEST(Renderer, AWaveIsAsHighAsItSays) {
  const Relief relief{{Wave{0.002, 90 * kDegree, 0.4, 0}}, 0.001, 0.1, 0};
  EXPECT_NEAR(relief.height_m(0.5, 0.1), 0.002 + 0.001 + 0.05, 1e-12);
  EXPECT_NEAR(relief.height_m(0, 0.3), -0.002 + 0.001, 1e-12);
}

TEST(Renderer, PointSpreadMovesLightButLosesNone) {
  Scene scene = single_dot({1, 0.5, 0, 0, 0, 0}, {0, 0, 0.0254});
  const auto dark = [&](double point_spread_px) {
    scene.sensor.point_spread_px = point_spread_px;
    double sum = 0;
    for (const double light : expose(scene).light) sum += scene.light.level * 0.9 - light;
    return sum;
  };
  EXPECT_NEAR(dark(1.5) / dark(0), 1, 1e-9);
}

TEST(Renderer, NoiseHasTheVarianceAskedFor) {
  Exposure grey{400, 400, {}};
  Sensor sensor;
  set_noise(sensor, 2.5);
  grey.light.assign(160000, light_from_grey(128, sensor.tone));
  const Picture picture = read_out(grey, sensor, 7);
  double sum = 0, squares = 0;
  for (const std::uint8_t value : picture.pixels) sum += value, squares += value * value;
  const double mean = sum / 160000;
  EXPECT_NEAR(mean, 128, 0.05);
  EXPECT_NEAR(std::sqrt(squares / 160000 - mean * mean), std::sqrt(2.5 * 2.5 + 1.0 / 12), 0.03);
}

TEST(Renderer, ToneCurvesInvert) {
  for (const ToneCurve tone : {ToneCurve::kLinear, ToneCurve::kSrgb})
    for (int grey = 0; grey <= 255; ++grey) EXPECT_NEAR(grey_from_light(light_from_grey(grey, tone), tone), grey, 1e-9);
}

// A change of the renderer must not go unnoticed: every accuracy table rests on it.
TEST(Renderer, SameSeedGivesTheSameBytes) {
  Scene scene;
  scene.camera = look_at_landmark({1.1, 0.5, 0.4, 0.1, 0.05, 0.02});
  scene.lens.k = {-0.12, 0.05, 0.0008, -0.0005};
  scene.light.shadows = {{0.9, 0.03, 0.05, 0.003, 0.3}};
  scene.light.gradient_x_per_m = 1;
  scene.board = {0.2, 2.0, 0.35, 0.6, {0.25, 0.5, 0.03, 2}};
  Sheet clock = clock_sheet(0.12);
  clock.x_m = -0.35;
  scene.sheets.push_back(clock);
  set_noise(scene.sensor, 1.5);
  const Picture picture = render(scene, 42);
  std::uint64_t hash = 0xCBF29CE484222325ULL;  // FNV-1a
  for (const std::uint8_t value : picture.pixels) hash = (hash ^ value) * 0x100000001B3ULL;
  EXPECT_EQ(hash, 0x3E0E19C8B1DF94D0ULL) << std::hex << hash;
  EXPECT_NE(render(scene, 43).pixels, picture.pixels);
}

}  // namespace
}  // namespace ninedot::test
