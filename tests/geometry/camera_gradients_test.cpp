#include "geometry/camera_gradients.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ninedot {
namespace {

double& intrinsic(CameraModel& camera, int i) {
  switch (i) {
    case 0:
      return camera.fx_px;
    case 1:
      return camera.fy_px;
    case 2:
      return camera.cx_px;
    case 3:
      return camera.cy_px;
    default:
      return camera.k[static_cast<std::size_t>(i - 4)];
  }
}

CameraModel lens(DistortionModel model) {
  CameraModel camera;
  camera.model = model;
  camera.fy_px = 731;
  if (model == DistortionModel::kPlumbBob) camera.k = {-0.21, 0.07, 0.001, -0.0008, 0.02};
  if (model == DistortionModel::kRationalPolynomial) camera.k = {0.4, 0.1, 0.0006, -0.0004, 0.01, 0.6, 0.15, 0.02};
  if (model == DistortionModel::kEquidistant) camera.k = {-0.03, 0.01, -0.004, 0.001};
  return camera;
}

class CameraGradients : public testing::TestWithParam<DistortionModel> {};

TEST_P(CameraGradients, EqualCentralDifferences) {
  const CameraModel camera = lens(GetParam());
  const int coefficients = GetParam() == DistortionModel::kEquidistant ? 4
                           : GetParam() == DistortionModel::kPlumbBob  ? 5
                                                                       : 8;
  for (const double x : {-0.4, -0.1, 0.02, 0.35})
    for (const double y : {-0.3, 0.0, 0.25}) {
      const Eigen::Vector2d point(x, y), pixel_px = camera.pixel_from_normalised(point);
      const IntrinsicGradient forward = pixel_by_intrinsics(camera, point), back = ray_by_intrinsics(camera, point);
      for (int i = 0; i < kIntrinsics; ++i) {
        if (i >= 4 + coefficients && GetParam() == DistortionModel::kEquidistant) {
          EXPECT_TRUE(forward.col(i).isZero()) << "the model has no such coefficient";
          continue;
        }
        const double step = i < 4 ? 1e-3 : 1e-6;
        CameraModel more = camera, less = camera;
        intrinsic(more, i) += step, intrinsic(less, i) -= step;
        const Eigen::Vector2d d_pixel =
            (more.pixel_from_normalised(point) - less.pixel_from_normalised(point)) / (2 * step);
        const Eigen::Vector2d d_ray =
            (*more.normalised_from_pixel(pixel_px) - *less.normalised_from_pixel(pixel_px)) / (2 * step);
        EXPECT_LT((forward.col(i) - d_pixel).norm(), 1e-5 * (1 + d_pixel.norm()))
            << "intrinsic " << i << " at " << x << ' ' << y;
        EXPECT_LT((back.col(i) - d_ray).norm(), 1e-5 * (1e-2 + d_ray.norm()))
            << "intrinsic " << i << " at " << x << ' ' << y;
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Models, CameraGradients,
                         testing::Values(DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial,
                                         DistortionModel::kEquidistant),
                         [](const auto& tested) {
                           return tested.param == DistortionModel::kPlumbBob             ? "plumb_bob"
                                  : tested.param == DistortionModel::kRationalPolynomial ? "rational_polynomial"
                                                                                         : "equidistant";
                         });

}  // namespace
}  // namespace ninedot
