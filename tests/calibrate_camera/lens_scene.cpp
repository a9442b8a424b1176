#include "tests/calibrate_camera/lens_scene.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/random.h"
#include "tests/support/renderer_optics.h"

namespace ninedot::test {

CameraPose held_pose(const CameraModel& camera, const Holding& holding, std::uint64_t seed, std::uint64_t index) {
  Random random(random_bits(seed, index));
  Viewpoint view;
  const double nearness = random.uniform(0, 1);  // as many views near as far
  view.distance_m = holding.min_distance_m / (1 - nearness * (1 - holding.min_distance_m / holding.max_distance_m));
  view.tilt_rad = holding.max_tilt_rad * std::sqrt(random.uniform(0, 1));
  view.azimuth_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  view.roll_rad = random.uniform(-0.3, 0.3);
  // Where P9 is to be seen, as a share of the way from the middle to the picture's edge.
  const double x_px = camera.cx_px + holding.off_centre_share * random.uniform(-0.5, 0.5) * camera.width_px;
  const double y_px = camera.cy_px + holding.off_centre_share * random.uniform(-0.5, 0.5) * camera.height_px;
  const Ray ray = ray_of_pixel(renderer_lens(camera), x_px, y_px);
  view.off_axis_x_rad = std::atan2(ray.direction.x(), ray.direction.z());
  view.off_axis_y_rad = std::atan2(ray.direction.y(), ray.direction.z());
  return look_at_landmark(view);
}

CameraPose frontal_pose(std::uint64_t seed, std::uint64_t index) {
  Random random(random_bits(seed, index));
  const double distance_m = random.uniform(0.5, 1);
  CameraPose pose;
  pose.position_m = {0.4 * distance_m * random.uniform(-1, 1), distance_m, 0.25 * distance_m * random.uniform(-1, 1)};
  return pose;
}

CameraFromLandmark sheet_before(const CameraPose& pose) {
  const Eigen::Matrix3d R_camera_sheet = rotation_of(pose).transpose();
  return {R_camera_sheet,
          -(R_camera_sheet * Eigen::Vector3d(pose.position_m[0], pose.position_m[1], pose.position_m[2]))};
}

Lens renderer_lens(const CameraModel& camera) {
  Lens lens;
  lens.width_px = camera.width_px, lens.height_px = camera.height_px;
  lens.fx_px = camera.fx_px, lens.fy_px = camera.fy_px, lens.cx_px = camera.cx_px, lens.cy_px = camera.cy_px;
  lens.model = camera.model == DistortionModel::kPlumbBob             ? LensModel::kPlumbBob
               : camera.model == DistortionModel::kRationalPolynomial ? LensModel::kRational
                                                                      : LensModel::kEquidistant;
  lens.k = camera.k;
  return lens;
}

Sheet dot_grid_sheet(const DotGrid& grid) {
  Sheet sheet;
  sheet.width_m = (grid.columns + 1) * grid.pitch_m, sheet.height_m = (grid.rows + 1) * grid.pitch_m;
  for (const PlaneDisc& disc : discs_of(grid))
    sheet.discs.push_back({disc.centre_m.x(), disc.centre_m.y(), disc.radius_m, 0.04});
  return sheet;
}

Picture held_picture(const CameraModel& camera, const CameraPose& pose, const Sheet& sheet, std::uint64_t seed) {
  Scene scene;
  scene.lens = renderer_lens(camera);
  scene.camera = pose;
  scene.sheets = {sheet};
  scene.wall.seed = seed;
  scene.light.gradient_x_per_m = random_normal(seed, 1) * 0.5;
  set_noise(scene.sensor, 1.5);
  return render(scene, seed);
}

SheetView perfect_view(const CameraModel& camera, const CameraPose& pose, std::span<const PlaneDisc> discs,
                       double sigma_px, std::uint64_t seed) {
  constexpr int kStretches = 12;
  Random random(seed);
  const Lens lens = renderer_lens(camera);
  SheetView view;
  const CameraFromLandmark T = sheet_before(pose);
  for (std::size_t disc = 0; disc < discs.size(); ++disc) {
    if ((T * Eigen::Vector3d(discs[disc].centre_m.x(), 0, discs[disc].centre_m.y())).z() < 2 * discs[disc].radius_m)
      continue;  // behind the camera, or beside it
    std::vector<EdgePoint> edges;
    bool inside = true;
    for (int i = 0; i < kStretches; ++i) {
      const auto at = [&](double angle) -> Eigen::Vector2d {
        const Eigen::Vector2d m =
            discs[disc].centre_m + discs[disc].radius_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        return pixel_of_wall_point(lens, pose, m.x(), m.y());
      };
      const double angle = 2 * std::numbers::pi * i / kStretches;
      const Eigen::Vector2d p = at(angle), along = at(angle + 1e-4) - at(angle - 1e-4);
      const Eigen::Vector2d normal = Eigen::Vector2d(along.y(), -along.x()).normalized();
      inside = inside && p.x() > 4 && p.y() > 4 && p.x() < camera.width_px - 5 && p.y() < camera.height_px - 5;
      edges.push_back({disc, p + sigma_px * random.normal() * normal, sigma_px});
    }
    if (!inside) continue;
    view.seen.push_back(
        {disc, centroid_of_disc_px(lens, pose,
                                   {discs[disc].centre_m.x(), discs[disc].centre_m.y(), discs[disc].radius_m, 0.04})});
    view.edges.insert(view.edges.end(), edges.begin(), edges.end());
  }
  return view;
}

}  // namespace ninedot::test
