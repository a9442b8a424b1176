#include "geometry/renumbered.h"

#include <gtest/gtest.h>

#include "geometry/landmark.h"

namespace ninedot {
namespace {

const CameraFromLandmark kPose{exp_so3({0.3, -0.2, 1.4}), {0.1, -0.2, 2.0}};

Eigen::Vector3d dot_before_camera(const CameraFromLandmark& T, std::size_t dot) {
  const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
  return T * Eigen::Vector3d(C.x(), 0, C.y());
}

TEST(Renumbered, SheetHasEveryDotWhereTheOneThatItIsCalledNowWas) {
  for (int eighths = 0; eighths < 8; ++eighths)
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot)
      EXPECT_LT((dot_before_camera(renumbered(kPose, eighths), dot) -
                 dot_before_camera(kPose, (dot + static_cast<std::size_t>(eighths)) % kRingDotCount))
                    .norm(),
                1e-12)
          << eighths << " " << dot;
}

TEST(Renumbered, BackIsWhereItWas) {
  EXPECT_LT((renumbered(renumbered(kPose, 3), -3).rotation - kPose.rotation).norm(), 1e-12);
  EXPECT_LT((renumbered(kPose, 8).rotation - kPose.rotation).norm(), 1e-12);
}

TEST(Renumbered, CameraIsTurnedAboutTheSheetsNormal) {
  const auto before = kPose.inverse(), after = renumbered(kPose, 2).inverse();
  EXPECT_LT((after.translation_m - R_renumbered_sheet(2) * before.translation_m).norm(), 1e-12);
  EXPECT_LT((after.rotation - R_renumbered_sheet(2) * before.rotation).norm(), 1e-12);
}

}  // namespace
}  // namespace ninedot
