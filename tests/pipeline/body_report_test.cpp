// The robot's place, from a frame's fix and the head's angles to what the registers carry, with its uncertainty.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>

#include "base/units.h"
#include "outputs/wire_output.h"
#include "pipeline/next_report.h"
#include "tests/geometry/askew_body.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr double kDeg = kRadPerDeg;
constexpr MonoTime kExposedAt{100s};

BodyGeometry mast() {
  BodyGeometry body = test::askew_body();
  body.pan_sigma_rad = 0.4 * kDeg;
  body.tilt_sigma_rad = 0.3 * kDeg;
  return body;
}

/// What may be wrong: the camera's place (along the world's axes, about its own), pan, tilt.
using Errors = Eigen::Matrix<double, 8, 1>;
/// x, y, z [m], yaw, pitch, roll [rad].
using Place = Eigen::Matrix<double, 6, 1>;

WorldFromCamera camera_in_world() {
  // Level, looking along (cos, sin) of 200 degrees, a little rolled.
  const Eigen::Matrix3d R =
      (AngleAxisd(200 * kDeg, Vector3d::UnitZ()) * AngleAxisd(-90 * kDeg, Vector3d::UnitZ()) *
       AngleAxisd(-90 * kDeg, Vector3d::UnitX()) * AngleAxisd(0.1, Vector3d(1, 2, 3).normalized()))
          .toRotationMatrix();
  return {R, {4, -2, 1.5}};
}

/// By forward kinematics of its own: from the body's origin along the chain to the camera, and back.
Place place_by_hand(const HeadAngles& head, const Errors& errors) {
  const BodyGeometry body = mast();
  const auto about = [](double rad, const Vector3d& axis) { return Eigen::Affine3d(AngleAxisd(rad, axis)); };
  const auto by = [](const Vector3d& m) { return Eigen::Affine3d(Eigen::Translation3d(m)); };
  const auto turned = [&](const Vector3d& rpy_rad) {
    return about(rpy_rad.z(), Vector3d::UnitZ()) * about(rpy_rad.y(), Vector3d::UnitY()) *
           about(rpy_rad.x(), Vector3d::UnitX());
  };
  Eigen::Affine3d optical = Eigen::Affine3d::Identity();
  optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Affine3d body_camera = by(body.pan_axis_m) * turned(body.mount_rpy_rad) *
                                      about(head.pan_rad + errors(6), Vector3d::UnitZ()) * by(body.tilt_axis_m) *
                                      about(-head.tilt_rad - errors(7), Vector3d::UnitY()) * by(body.camera_m) *
                                      turned(body.camera_rpy_rad) * optical;
  Eigen::Affine3d world_camera = Eigen::Affine3d::Identity();
  world_camera.linear() = camera_in_world().rotation;
  world_camera.translation() = camera_in_world().translation_m + errors.head<3>();
  const Vector3d turn_rad = errors.segment<3>(3);
  if (turn_rad.norm() > 0) world_camera = world_camera * about(turn_rad.norm(), turn_rad.normalized());
  const Eigen::Affine3d world_body = world_camera * body_camera.inverse();
  const Eigen::Matrix3d R = world_body.linear();
  Place place;
  place << world_body.translation(), std::atan2(R(1, 0), R(0, 0)), std::asin(-R(2, 0)), std::atan2(R(2, 1), R(2, 2));
  return place;
}

PoseInformation camera_covariance() {
  PoseInformation root = PoseInformation::Zero();
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      root(i, j) = 1e-3 * (i == j ? 2 : 0.3 * static_cast<double>((i + 2 * j) % 3 - 1));
  return root * root.transpose();
}

Fix valid_fix() {
  Fix fix;
  fix.reason = Reason::kNone;
  LandmarkFix landmark;
  landmark.id = 5;
  landmark.T_world_camera = camera_in_world();
  landmark.covariance_world = camera_covariance();
  PoseCandidate candidate;
  candidate.pose.T_landmark_camera = {Eigen::Matrix3d::Identity(), {0, 2, 0}};
  candidate.pose.covariance = camera_covariance();
  (void)landmark.candidates.list.try_push_back(candidate);
  landmark.place_is_sure = true;
  (void)fix.landmarks.try_push_back(landmark);
  return fix;
}

Frame exposed_frame() {
  Frame frame;
  frame.set_exposure(kExposedAt);
  return frame;
}

const HeadAngles kThen{25 * kDeg, -10 * kDeg};

/// The head has moved on since the exposure.
HeadSnapshot moved_head() {
  HeadSnapshot head;
  head.track = HeadTrack(kThen);
  head.track.add(kExposedAt + 5ms, {40 * kDeg, 3 * kDeg});
  return head;
}

TEST(BodyReport, IsAsTheHeadStoodAtTheExposureAndAsUncertainAsHeadAndCameraTogether) {
  const HeadSnapshot head = moved_head();
  const BodyGeometry body = mast();
  const Report report =
      next_report({}, exposed_frame(), valid_fix(), {.now = kExposedAt + 9ms, .head = &head, .body = &body});
  const WireReport wire = wire_report(report, {PoseContent::kBodyInWorld, EulerConvention::kZyx});

  const Place place = place_by_hand(kThen, Errors::Zero());
  Eigen::Matrix<double, 6, 8> J;
  constexpr double kStep = 1e-6;
  for (Eigen::Index i = 0; i < 8; ++i)
    J.col(i) =
        (place_by_hand(kThen, kStep * Errors::Unit(i)) - place_by_hand(kThen, -kStep * Errors::Unit(i))) / (2 * kStep);
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();
  covariance.topLeftCorner<6, 6>() = camera_covariance();
  covariance(6, 6) = body.pan_sigma_rad * body.pan_sigma_rad;
  covariance(7, 7) = body.tilt_sigma_rad * body.tilt_sigma_rad;
  const Place sigma = (J * covariance * J.transpose()).diagonal().cwiseSqrt();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(wire.pose.position_mm[i], place(at) * 1000, 1e-9) << i;
    EXPECT_NEAR(wire.angles_deg[i], place(at + 3) / kDeg, 1e-9) << i;
    EXPECT_NEAR(wire.sigma_mm[i], sigma(at) * 1000, 1e-5 * wire.sigma_mm[i]) << i;
    EXPECT_NEAR(wire.sigma_angles_deg[i], sigma(at + 3) / kDeg, 1e-5 * wire.sigma_angles_deg[i]) << i;
  }
  // Or the angles' own uncertainty would not show.
  covariance(6, 6) = covariance(7, 7) = 0;
  const Place without = (J * covariance * J.transpose()).diagonal().cwiseSqrt();
  EXPECT_GT(sigma(3), 1.5 * without(3)) << "heading";
}

TEST(BodyReport, TakesTheRecordedAnglesWhereThereIsNoHead) {
  Frame frame = exposed_frame();
  frame.head = kThen;
  const BodyGeometry body = mast();
  const Report report = next_report({}, frame, valid_fix(), {.now = kExposedAt, .body = &body});
  const Place place = place_by_hand(kThen, Errors::Zero());
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(report.body_in_world.position_m[i], place(static_cast<Eigen::Index>(i)), 1e-12);
}

/// The head may follow another landmark than the one whose pose is reported.
TEST(BodyReport, NamesTheLandmarksOfTheFrameThatAHeadMayTurnTo) {
  Fix fix = valid_fix();
  LandmarkFix other = fix.landmarks[0];
  other.id = 6;
  other.candidates.list[0].pose.T_landmark_camera = {Eigen::Matrix3d::Identity(), {0.5, 3, -0.25}};
  ASSERT_TRUE(fix.landmarks.try_push_back(other));
  other.id = 7;
  other.verdict = Reason::kUncertain;
  other.place_is_sure = false;
  ASSERT_TRUE(fix.landmarks.try_push_back(other));
  Report report = next_report({}, exposed_frame(), fix, {.now = kExposedAt});
  EXPECT_EQ(report.landmark_id, 5);
  ASSERT_EQ(report.sights.size(), 2U);
  EXPECT_EQ(report.sights[0].id, 5);
  EXPECT_EQ(report.sights[0].exposed_at, exposed_frame().exposed_at());
  EXPECT_EQ(report.sights[1].id, 6);
  EXPECT_EQ(report.sights[1].landmark_camera_m, (std::array<double, 3>{-0.5, -3, 0.25}));
  EXPECT_TRUE(next_report(report, exposed_frame(), Fix{}, {.now = kExposedAt}).sights.empty());

  fix.reason = fix.landmarks[0].verdict = Reason::kAmbiguous;
  report = next_report({}, exposed_frame(), fix, {.now = kExposedAt});
  EXPECT_FALSE(report.valid);
  EXPECT_EQ(report.sights.size(), 2U) << "which of two mirror images it is makes no difference to a head";
}

/// A head that moves on while nothing is found does not move the robot.
TEST(BodyReport, StaysWhereItWasWhileNothingIsFound) {
  const HeadSnapshot head = moved_head();
  const BodyGeometry body = mast();
  const Report before =
      next_report({}, exposed_frame(), valid_fix(), {.now = kExposedAt, .head = &head, .body = &body});
  Frame later = exposed_frame();
  later.set_exposure(kExposedAt + 30ms);
  const Report after = next_report(before, later, Fix{}, {.now = kExposedAt + 31ms, .head = &head, .body = &body});
  EXPECT_FALSE(after.valid);
  EXPECT_NE(after.head.pan_rad, before.head.pan_rad);
  EXPECT_EQ(after.body_in_world.position_m, before.body_in_world.position_m);
  EXPECT_EQ(after.covariance_body, before.covariance_body);
}

TEST(BodyReport, OfTheRivalIsTheRivalsCameraSeenFromTheBody) {
  Fix fix = valid_fix();
  RivalReading& rival = fix.landmarks[0].candidates.rival.emplace();
  rival.odds = 0.004;
  rival.T_landmark_camera = {AngleAxisd(0.3, Vector3d::UnitY()).toRotationMatrix(), {0.5, 2, 0.1}};
  Frame frame = exposed_frame();
  frame.head = kThen;
  const BodyGeometry body = mast();
  const Report report = next_report({}, frame, fix, {.now = kExposedAt, .body = &body});
  const auto apart = [](const ReportPose& a, const ReportPose& b) {
    const auto quaternion = [](const ReportPose& p) {
      return Eigen::Quaterniond(p.quaternion_wxyz[0], p.quaternion_wxyz[1], p.quaternion_wxyz[2], p.quaternion_wxyz[3]);
    };
    return std::pair(
        Vector3d(quaternion(a).conjugate() * (Vector3d(b.position_m.data()) - Vector3d(a.position_m.data()))),
        quaternion(a).conjugate() * quaternion(b));
  };
  const auto [arm_m, turn] = apart(report.camera_in_world, report.body_in_world);
  const auto [rival_arm_m, rival_turn] = apart(report.rival.camera_in_world, report.rival.body_in_world);
  EXPECT_LT((arm_m - rival_arm_m).norm(), 1e-12);
  EXPECT_LT(turn.angularDistance(rival_turn), 1e-7);
  EXPECT_GT(std::abs(report.rival.body_in_world.position_m[0] - report.body_in_world.position_m[0]), 0.1)
      << "it is another place";
}

TEST(BodyReport, OfTheRivalIsNoLikelierThanAllOthersTogether) {
  Fix fix = valid_fix();
  fix.landmarks[0].candidates.rival.emplace().odds = 0.4;  // of the sheet alone
  const auto odds = [&](double ambiguity) {
    fix.landmarks[0].candidates.list[0].pose.ambiguity = ambiguity;
    return next_report({}, exposed_frame(), fix, {.now = kExposedAt}).rival.odds;
  };
  EXPECT_EQ(odds(0.5), 0.4);
  EXPECT_EQ(odds(0.002), 0.002) << "its map has decided";
}

TEST(PoseRegisters, CarryTheCameraInTheWorldUnlessAskedOtherwise) {
  const Report report = next_report({}, exposed_frame(), valid_fix(), {.now = kExposedAt});
  const WireReport by_default = wire_report(report),
                   landmark = wire_report(report, {PoseContent::kCameraInLandmark, {}});
  EXPECT_EQ(by_default.pose.position_mm, (std::array<double, 3>{4000, -2000, 1500}));
  EXPECT_EQ(landmark.pose.position_mm, (std::array<double, 3>{0, 2000, 0}));
  EXPECT_EQ(landmark.pose.position_mm, landmark.camera_in_landmark.position_mm);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const Eigen::Matrix3d R = camera_in_world().rotation, rotation = camera_covariance().bottomRightCorner<3, 3>();
    EXPECT_NEAR(by_default.sigma_deg[i], std::sqrt((R * rotation * R.transpose())(at, at)) / kDeg, 1e-9);
    EXPECT_NEAR(landmark.sigma_deg[i], std::sqrt(rotation(at, at)) / kDeg, 1e-9) << "its axes are the landmark's";
    EXPECT_NEAR(landmark.sigma_mm[i], std::sqrt(camera_covariance()(at, at)) * 1000, 1e-9);
  }
}

}  // namespace
}  // namespace ninedot
