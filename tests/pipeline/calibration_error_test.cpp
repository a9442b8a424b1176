// What a calibration leaves open, in poses, in places of the camera and in its track: pictures of cameras whose true
// numbers are drawn from a covariance, solved with the nominal ones.
#include "pipeline/calibration_error.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <chrono>
#include <cmath>

#include "base/units.h"
#include "pipeline/localiser.h"
#include "pipeline/room_localiser.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/random.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Intrinsics = Eigen::Matrix<double, kIntrinsics, 1>;

CameraModel nominal_camera() {
  CameraModel camera;
  camera.k = {-0.12, 0.05, 0.0008, -0.0005, 0, 0, 0, 0};
  return camera;
}

/// Of a calibration by few pictures: both focal lengths err together, and k2 against k1.
IntrinsicCovariance poor_calibration() {
  Intrinsics sigma = Intrinsics::Zero();
  sigma.head<9>() << 3, 3, 2, 2, 0.006, 0.02, 5e-4, 5e-4, 0;
  IntrinsicCovariance correlation = IntrinsicCovariance::Identity();
  correlation(0, 1) = correlation(1, 0) = 0.95;
  correlation(4, 5) = correlation(5, 4) = -0.8;
  return sigma.asDiagonal() * correlation * sigma.asDiagonal();
}

test::Lens lens_with(const CameraModel& camera, const Intrinsics& error) {
  test::Lens lens;
  lens.fx_px = camera.fx_px + error[0], lens.fy_px = camera.fy_px + error[1];
  lens.cx_px = camera.cx_px + error[2], lens.cy_px = camera.cy_px + error[3];
  for (std::size_t i = 0; i < 8; ++i) lens.k[i] = camera.k[i] + error[static_cast<Eigen::Index>(4 + i)];
  return lens;
}

Intrinsics drawn(const IntrinsicCovariance& covariance, test::Random& random) {
  Intrinsics z, error = Intrinsics::Zero();
  for (double& value : z) value = random.normal();
  const Eigen::Matrix<double, 8, 8> L = covariance.topLeftCorner<8, 8>().llt().matrixL();  // k3 and beyond are exact
  error.head<8>() = L * z.head<8>();
  return error;
}

Frame frame_of(const test::Picture& picture, std::uint64_t number) {
  Frame frame;
  frame.number = number;
  frame.luma = picture.view();
  frame.set_exposure(MonoTime(5s + number * 28ms));
  return frame;
}

WorldFromCamera truth(const test::CameraPose& pose) {
  const auto& q = pose.quaternion_wxyz;
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(),
          Eigen::Map<const Eigen::Vector3d>(pose.position_m.data())};
}

/// Root mean square of errors in units of their stated sigma, all six freedoms together by position and rotation.
struct Normalised {
  double position = 0, rotation = 0;
  int count = 0;
  void add(const PoseStep& error, const PoseInformation& covariance) {
    position += error.head<3>().dot(covariance.topLeftCorner<3, 3>().ldlt().solve(error.head<3>())) / 3;
    rotation += error.tail<3>().dot(covariance.bottomRightCorner<3, 3>().ldlt().solve(error.tail<3>())) / 3;
    ++count;
  }
  double position_rms() const { return std::sqrt(position / count); }
  double rotation_rms() const { return std::sqrt(rotation / count); }
};

/// Lean enough that the mirror image is excluded: this is about the calibration.
test::Viewpoint somewhere(test::Random& random) {
  return {.distance_m = random.uniform(0.8, 2.2),
          .tilt_rad = random.uniform(25, 50) * kRadPerDeg,
          .azimuth_rad = random.uniform(-3, 3),
          .off_axis_x_rad = random.uniform(-0.25, 0.25),
          .off_axis_y_rad = random.uniform(-0.18, 0.18)};
}

WorldFromCamera as_world(const PoseEstimate& pose) {
  return {pose.T_landmark_camera.rotation, pose.T_landmark_camera.translation_m};
}

TEST(CalibrationError, IsWhatACameraThatErrsInOneNumberMakesOfThePose) {
  const CameraModel camera = nominal_camera();
  const double error_by[] = {2, 2, 1.5, 1.5, 0.005, 0.02, 5e-4, 5e-4};
  test::Random random(7);
  for (Eigen::Index i = 0; i < 8; ++i) {
    test::Scene scene;
    scene.camera = test::look_at_landmark(somewhere(random));
    scene.sensor.noise_a = scene.sensor.noise_b = 0;
    Intrinsics error = Intrinsics::Zero();
    error[i] = error_by[i];
    IntrinsicCovariance covariance = IntrinsicCovariance::Zero();
    covariance(i, i) = error[i] * error[i];
    LocaliserOptions options{.trust = {.max_sigma_share = 1}};
    const auto pose_of = [&](const Intrinsics& by, bool informed) {
      options.intrinsics = informed ? std::optional(covariance) : std::nullopt;
      scene.lens = lens_with(camera, by);
      Localiser unit(camera, options);
      const test::Picture picture = test::render(scene, 1);
      const Fix& fix = unit.process(frame_of(picture, 1));
      EXPECT_FALSE(fix.landmarks.empty());
      return fix.main().pose();
    };
    const PoseEstimate right = pose_of(Intrinsics::Zero(), false), informed = pose_of(Intrinsics::Zero(), true);
    const PoseEstimate wrong = pose_of(error, false);
    const PoseStep moved = step_between(as_world(right), as_world(wrong));
    const Matrix6d share = informed.covariance - right.covariance;
    // A covariance of one number has one direction: that of the step which its error makes.
    for (const Eigen::Index part : {0, 3}) {
      const Eigen::Vector3d step = moved.segment<3>(part);
      const double sigma = std::sqrt(share.block<3, 3>(part, part).trace());
      const double numerical = part == 0 ? 1e-4 : 5e-5;  // of the outlines in 8 bits [m, rad]
      EXPECT_NEAR(sigma, step.norm(), 0.12 * step.norm() + numerical) << "number " << i;
      if (step.norm() < 10 * numerical) continue;
      EXPECT_GT(std::sqrt(step.dot(share.block<3, 3>(part, part) * step)), 0.9 * sigma * step.norm()) << "number " << i;
    }
  }
}

TEST(CalibrationError, MakesSigmasOfPosesHonest) {
  const CameraModel camera = nominal_camera();
  const IntrinsicCovariance covariance = poor_calibration();
  Normalised with, without;
  test::Random random(20261122);
  for (int trial = 0; trial < 40; ++trial) {
    test::Scene scene;
    scene.camera = test::look_at_landmark(somewhere(random));
    scene.lens = lens_with(camera, drawn(covariance, random));
    set_noise(scene.sensor, 1.5);
    const test::Picture picture = test::render(scene, random.bits());
    Localiser unit(camera, {.intrinsics = covariance}), blind(camera, {});
    const Fix& fix = unit.process(frame_of(picture, 1));
    const Fix& blind_fix = blind.process(frame_of(picture, 1));
    ASSERT_EQ(fix.reason, Reason::kNone) << trial;
    const PoseStep error = step_between(as_world(fix.main().pose()), truth(scene.camera));
    with.add(error, fix.main().pose().covariance);
    without.add(error, blind_fix.main().pose().covariance);
    const Matrix6d share = fix.main().pose().covariance - blind_fix.main().pose().covariance;
    EXPECT_NEAR(fix.main().calibration_sigma_m, position_sigma_m(share), 1e-9);
  }
  EXPECT_GT(with.position_rms(), 0.8);
  EXPECT_LT(with.position_rms(), 1.3);
  EXPECT_GT(with.rotation_rms(), 0.8);
  EXPECT_LT(with.rotation_rms(), 1.3);
  EXPECT_GT(without.position_rms(), 3) << "or these pictures test nothing";
}

/// On the wall y = 0: no two pairs of them are alike.
struct Hung {
  std::uint16_t id;
  double x_m, z_m;
};
constexpr Hung kWall[] = {{1, -0.45, 0.05}, {2, 0.0, -0.12}, {3, 0.62, 0.2}};

LandmarkMap map_of_wall() {
  std::vector<MappedLandmark> landmarks;
  for (const Hung& hung : kWall)
    landmarks.push_back({hung.id, std::string(), place_upright({hung.x_m, 0, hung.z_m}, 0)});
  return LandmarkMap(landmarks);
}

test::Scene wall_scene(const test::Viewpoint& viewpoint) {
  test::Scene scene;
  scene.camera = test::look_at_landmark(viewpoint);
  scene.sheets.clear();
  for (const Hung& hung : kWall) {
    scene.sheets.push_back(test::nine_dot_sheet());
    scene.sheets.back().x_m = hung.x_m, scene.sheets.back().z_m = hung.z_m;
  }
  set_noise(scene.sensor, 1.5);
  return scene;
}

TEST(CalibrationError, IsNotAveragedDownByManyLandmarksNorByManyFrames) {
  const CameraModel camera = nominal_camera();
  // Of a better one: sheets without codes are told apart by their distances, which a poor calibration spoils.
  const IntrinsicCovariance covariance = poor_calibration() / 50;
  Normalised world, track, without;
  test::Random random(3);
  for (int trial = 0; trial < 30; ++trial) {
    test::Scene scene = wall_scene({.distance_m = random.uniform(1.9, 2.4),
                                    .tilt_rad = random.uniform(0.3, 0.6),
                                    .azimuth_rad = random.uniform(-0.4, 0.4)});
    scene.lens = lens_with(camera, drawn(covariance, random));
    const test::Exposure exposure = test::expose(scene);
    RoomLocaliser unit(camera, {.map = map_of_wall(), .intrinsics = covariance});
    RoomLocaliser blind(camera, {.map = map_of_wall()});
    const WorldFromCamera T = truth(scene.camera);
    std::optional<WorldFix> newest;
    std::optional<TrackedPose> tracked, blindly;
    for (std::uint64_t frame = 0; frame < 12; ++frame) {
      const test::Picture picture = test::read_out(exposure, scene.sensor, random.bits());
      const Fix& fix = unit.process(frame_of(picture, frame));
      if (fix.world) {
        newest = fix.world;
        EXPECT_LT(fix.main().calibration_sigma_world_m, position_sigma_m(fix.world->covariance));
      }
      tracked = fix.track;
      blindly = blind.process(frame_of(picture, frame)).track;
    }
    if (!newest || !tracked || !blindly) continue;
    world.add(step_between(newest->T_world_camera, T), newest->covariance);
    track.add(step_between(tracked->motion.T_world_camera, T), tracked->covariance.topLeftCorner<6, 6>());
    without.add(step_between(blindly->motion.T_world_camera, T), blindly->covariance.topLeftCorner<6, 6>());
  }
  EXPECT_GT(world.count, 25);
  for (const Normalised& of : {world, track}) {
    EXPECT_GT(of.position_rms(), 0.8);
    EXPECT_LT(of.position_rms(), 1.3);
    EXPECT_GT(of.rotation_rms(), 0.8);
    EXPECT_LT(of.rotation_rms(), 1.3);
  }
  EXPECT_GT(without.position_rms(), 2) << "or these pictures test nothing";
}

TEST(CalibrationError, ThatIsTooLargeMakesPosesNotValid) {
  const CameraModel camera = nominal_camera();
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.5, .tilt_rad = 0.5});
  scene.lens = lens_with(camera, Intrinsics::Zero());
  const test::Picture picture = test::render(scene, 1);
  for (const Solver solver : {Solver::kFull, Solver::kEllipse}) {
    Localiser fair(camera, {.seeker = {.solver = solver}, .intrinsics = poor_calibration()});
    EXPECT_EQ(fair.process(frame_of(picture, 1)).reason, Reason::kNone);
    Localiser poor(camera, {.seeker = {.solver = solver}, .intrinsics = poor_calibration() * 400});
    const Fix& fix = poor.process(frame_of(picture, 1));
    EXPECT_EQ(fix.reason, Reason::kUncertain);
    EXPECT_GT(fix.main().calibration_sigma_m, 0.03 * 1.5);
  }
}

TEST(CalibrationError, AllocatesNothingInTheFramePath) {
  const CameraModel camera = nominal_camera();
  test::Scene scene = wall_scene({.distance_m = 2.2, .tilt_rad = 0.4, .azimuth_rad = 0.2});
  scene.lens = lens_with(camera, Intrinsics::Zero());
  const test::Picture picture = test::render(scene, 1);
  RoomLocaliser room(camera, {.map = map_of_wall(), .intrinsics = poor_calibration()});
  Localiser alone(camera, {.intrinsics = poor_calibration()});
  for (std::uint64_t frame = 0; frame < 3; ++frame) {
    const test::AllocationGuard guard;
    EXPECT_FALSE(room.process(frame_of(picture, frame)).landmarks.empty());
    EXPECT_FALSE(alone.process(frame_of(picture, frame)).landmarks.empty());
    EXPECT_EQ(guard.allocations(), 0U) << frame;
  }
}

}  // namespace
}  // namespace ninedot
