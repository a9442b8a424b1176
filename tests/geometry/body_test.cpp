#include "geometry/body.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "base/units.h"
#include "geometry/euler_angles.h"
#include "tests/geometry/askew_body.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

using Eigen::Vector3d;
using WorldFromCamera = Transform<frame::World, frame::Camera>;

constexpr double kDeg = kRadPerDeg;

TEST(Body, WithoutGeometryTheCameraIsItsOriginAndLooksAhead) {
  const CameraOnBody camera = camera_on_body({}, {});
  EXPECT_TRUE(camera.T_body_camera.translation_m.isZero());
  const Eigen::Matrix3d& R = camera.T_body_camera.rotation;
  EXPECT_TRUE((R * Vector3d::UnitZ()).isApprox(Vector3d::UnitX(), 1e-15)) << "what lies ahead";
  EXPECT_TRUE((R * Vector3d::UnitX()).isApprox(-Vector3d::UnitY(), 1e-15)) << "the picture's right";
  EXPECT_TRUE((R * Vector3d::UnitY()).isApprox(-Vector3d::UnitZ(), 1e-15)) << "the picture's lower side";
  EXPECT_TRUE(camera.covariance.isZero());
}

TEST(Body, PanTurnsToTheLeftAndTiltUpwards) {
  const Vector3d ahead = Vector3d::UnitZ();
  const Vector3d left = camera_on_body({}, {30 * kDeg, 0}).T_body_camera.rotation * ahead;
  EXPECT_TRUE(left.isApprox(Vector3d(std::cos(30 * kDeg), std::sin(30 * kDeg), 0), 1e-14));
  const Vector3d up = camera_on_body({}, {0, 20 * kDeg}).T_body_camera.rotation * ahead;
  EXPECT_TRUE(up.isApprox(Vector3d(std::cos(20 * kDeg), 0, std::sin(20 * kDeg)), 1e-14));
  const Vector3d both = camera_on_body({}, {90 * kDeg, 20 * kDeg}).T_body_camera.rotation * ahead;
  EXPECT_TRUE(both.isApprox(Vector3d(0, std::cos(20 * kDeg), std::sin(20 * kDeg)), 1e-14)) << "pan turns the tilt axis";
}

TEST(Body, TheCameraSwingsAboutBothAxes) {
  BodyGeometry body;
  body.pan_axis_m = {0.2, 0, 1};
  body.tilt_axis_m = {0.1, 0, 0};
  body.camera_m = {0.05, 0, 0};
  EXPECT_TRUE(camera_on_body(body, {}).T_body_camera.translation_m.isApprox(Vector3d(0.35, 0, 1), 1e-14));
  EXPECT_TRUE(camera_on_body(body, {90 * kDeg, 0}).T_body_camera.translation_m.isApprox(Vector3d(0.2, 0.15, 1), 1e-14));
  EXPECT_TRUE(camera_on_body(body, {0, 90 * kDeg}).T_body_camera.translation_m.isApprox(Vector3d(0.3, 0, 1.05), 1e-14));
}

TEST(Body, IsTheProductOfTheTransformsThatTheHeaderNames) {
  const auto about = [](double angle_rad, const Vector3d& axis) {
    Eigen::Affine3d T = Eigen::Affine3d::Identity();
    T.rotate(Eigen::AngleAxisd(angle_rad, axis));
    return T;
  };
  const auto turned = [&](const Vector3d& rpy_rad) {
    return about(rpy_rad.z(), Vector3d::UnitZ()) * about(rpy_rad.y(), Vector3d::UnitY()) *
           about(rpy_rad.x(), Vector3d::UnitX());
  };
  const BodyGeometry body = test::askew_body();
  const HeadAngles head{0.4, -0.3};
  const Eigen::Affine3d expected = Eigen::Translation3d(body.pan_axis_m) * turned(body.mount_rpy_rad) *
                                   about(head.pan_rad, Vector3d::UnitZ()) * Eigen::Translation3d(body.tilt_axis_m) *
                                   about(-head.tilt_rad, Vector3d::UnitY()) * Eigen::Translation3d(body.camera_m) *
                                   turned(body.camera_rpy_rad) * turned(Vector3d(-90, 0, -90) * kDeg);
  const BodyFromCamera T = camera_on_body(body, head).T_body_camera;
  EXPECT_TRUE(T.rotation.isApprox(expected.rotation(), 1e-14));
  EXPECT_TRUE(T.translation_m.isApprox(expected.translation(), 1e-14));
}

template <typename To, typename From>
Eigen::Matrix<double, 6, 1> step_of(const Transform<To, From>& from, const Transform<To, From>& to) {
  Eigen::Matrix<double, 6, 1> step;
  step << to.translation_m - from.translation_m, log_so3(from.rotation.transpose() * to.rotation);
  return step;
}
template <typename To, typename From>
Transform<To, From> moved(const Transform<To, From>& T, const Eigen::Matrix<double, 6, 1>& step) {
  return {T.rotation * exp_so3(step.tail<3>()), T.translation_m + step.head<3>()};
}

constexpr double kStep = 1e-6;

TEST(Body, CovarianceOfTheHeadIsThatOfDifferences) {
  BodyGeometry body = test::askew_body();
  for (const HeadAngles& head : {HeadAngles{0, 0}, HeadAngles{0.7, -0.4}, HeadAngles{-1.2, 0.9}}) {
    body.pan_sigma_rad = 0.01;
    body.tilt_sigma_rad = 0.02;
    body.mount_sigma_m = 0.003;
    body.mount_sigma_rad = 0.004;
    BodyCovariance expected = BodyCovariance::Zero();
    expected.diagonal() << Vector3d::Constant(9e-6), Vector3d::Constant(16e-6);
    const auto at = [&](double pan, double tilt) {
      return camera_on_body(body, {head.pan_rad + pan, head.tilt_rad + tilt}).T_body_camera;
    };
    const Eigen::Matrix<double, 6, 1> pan = step_of(at(-kStep, 0), at(kStep, 0)) / (2 * kStep);
    const Eigen::Matrix<double, 6, 1> tilt = step_of(at(0, -kStep), at(0, kStep)) / (2 * kStep);
    expected += 1e-4 * pan * pan.transpose() + 4e-4 * tilt * tilt.transpose();
    EXPECT_LT((camera_on_body(body, head).covariance - expected).norm(), 1e-8 * expected.norm());
  }
}

TEST(Body, CovarianceInTheWorldIsThatOfDifferences) {
  test::Random random(3);
  const auto any_covariance = [&] {
    BodyCovariance root;
    for (int i = 0; i < 36; ++i) root(i) = random.normal();
    return BodyCovariance(root * root.transpose());
  };
  CameraOnBody camera = camera_on_body(test::askew_body(), {0.4, -0.3});
  camera.covariance = any_covariance();
  const BodyCovariance camera_covariance = any_covariance();
  const WorldFromCamera T{exp_so3({0.3, -1.1, 2.0}), {3, -4, 1}};
  BodyCovariance of_camera, of_mount;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Matrix<double, 6, 1> step = kStep * Eigen::Matrix<double, 6, 1>::Unit(i);
    const auto by_camera = [&](double sign) { return body_in_world(moved(T, sign * step), {}, camera).T_world_body; };
    const auto by_mount = [&](double sign) {
      return body_in_world(T, {}, {moved(camera.T_body_camera, sign * step)}).T_world_body;
    };
    of_camera.col(i) = step_of(by_camera(-1), by_camera(1)) / (2 * kStep);
    of_mount.col(i) = step_of(by_mount(-1), by_mount(1)) / (2 * kStep);
  }
  const BodyPose pose = body_in_world(T, camera_covariance, camera);
  const BodyCovariance expected =
      of_camera * camera_covariance * of_camera.transpose() + of_mount * camera.covariance * of_mount.transpose();
  EXPECT_LT((pose.covariance - expected).norm(), 1e-7 * expected.norm());
}

TEST(Body, StandsWhereItsCameraSaysHoweverTheHeadIsTurned) {
  const BodyGeometry body = test::askew_body();
  const WorldFromBody truth{rotation_of(YawPitchRoll{0.9, 0.02, -0.03}), {2, 1, 0.1}};
  for (const HeadAngles& head : {HeadAngles{0, 0}, HeadAngles{0.7, -0.4}, HeadAngles{-1.2, 0.9}}) {
    const CameraOnBody camera = camera_on_body(body, head);
    const BodyPose pose = body_in_world(truth * camera.T_body_camera, {}, camera);
    EXPECT_LT(step_of(truth, pose.T_world_body).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace ninedot
