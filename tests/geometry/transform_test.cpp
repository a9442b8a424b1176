#include "geometry/transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

namespace ninedot {
namespace {

class TransformLaws : public testing::Test {
 protected:
  TransformLaws()
      : seed_(std::hash<std::string>{}(testing::UnitTest::GetInstance()->current_test_info()->name())),
        random_(seed_) {}

  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Eigen::Vector3d vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }

  template <typename To, typename From>
  Transform<To, From> transform() {
    return {exp_so3(vector(1.8)), vector(5)};
  }

  static constexpr int kRuns = 200;
  std::size_t seed_;
  std::mt19937_64 random_;
};

template <typename To, typename From>
double difference(const Transform<To, From>& a, const Transform<To, From>& b) {
  return (a.rotation - b.rotation).norm() + (a.translation_m - b.translation_m).norm();
}

TEST_F(TransformLaws, ProductWithTheInverseIsTheIdentity) {
  for (int run = 0; run < kRuns; ++run) {
    const auto T = transform<frame::Camera, frame::Landmark>();
    ASSERT_LT(difference(T * T.inverse(), Transform<frame::Camera, frame::Camera>{}), 1e-12) << "seed " << seed_;
    ASSERT_LT(difference(T.inverse() * T, Transform<frame::Landmark, frame::Landmark>{}), 1e-12) << "seed " << seed_;
  }
}

TEST_F(TransformLaws, ProductIsAssociative) {
  for (int run = 0; run < kRuns; ++run) {
    const auto A = transform<frame::World, frame::Landmark>();
    const auto B = transform<frame::Landmark, frame::Camera>();
    const auto C = transform<frame::Camera, frame::World>();
    ASSERT_LT(difference((A * B) * C, A * (B * C)), 1e-12) << "seed " << seed_;
  }
}

TEST_F(TransformLaws, ProductActsOnPointsLikeOneAfterTheOther) {
  for (int run = 0; run < kRuns; ++run) {
    const auto A = transform<frame::World, frame::Landmark>();
    const auto B = transform<frame::Landmark, frame::Camera>();
    const Eigen::Vector3d p = vector(3);
    ASSERT_LT(((A * B) * p - A * (B * p)).norm(), 1e-12) << "seed " << seed_;
  }
}

TEST_F(TransformLaws, ExpOfLogIsTheRotationAndLogOfExpTheVector) {
  for (int run = 0; run < kRuns; ++run) {
    // Down to 1e-15 rad: the small-angle branch included.
    const Eigen::Vector3d rotation_rad = vector(1).normalized() * std::pow(10.0, number(-15, 0.49));
    const Eigen::Matrix3d R = exp_so3(rotation_rad);
    ASSERT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14) << "seed " << seed_;
    ASSERT_LT((exp_so3(log_so3(R)) - R).norm(), 1e-13) << "seed " << seed_;
    ASSERT_LT((log_so3(R) - rotation_rad).norm(), 2e-8) << "seed " << seed_ << " " << rotation_rad.transpose();
  }
}

TEST_F(TransformLaws, QuaternionRotatesLikeTheMatrixAndHasPositiveW) {
  for (int run = 0; run < kRuns; ++run) {
    const auto T = transform<frame::Camera, frame::Landmark>();
    const Eigen::Quaterniond q = T.quaternion();
    ASSERT_GE(q.w(), 0) << "seed " << seed_;
    ASSERT_NEAR(q.norm(), 1, 1e-14) << "seed " << seed_;
    ASSERT_LT((q.toRotationMatrix() - T.rotation).norm(), 1e-13) << "seed " << seed_;
  }
}

template <typename A, typename B>
concept CanMultiply = requires(A a, B b) {
  a* b;
};
// A product whose inner frames differ does not compile.
static_assert(CanMultiply<Transform<frame::World, frame::Landmark>, Transform<frame::Landmark, frame::Camera>>);
static_assert(!CanMultiply<Transform<frame::World, frame::Landmark>, CameraFromLandmark>);

}  // namespace
}  // namespace ninedot
