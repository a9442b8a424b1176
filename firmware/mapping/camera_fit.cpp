#include "mapping/camera_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "geometry/levenberg_marquardt.h"
#include "geometry/planar_pose.h"

namespace ninedot {
namespace {

/// A reading that is worse by so much is out of the question, also where noise was taken for half of what it is: odds
/// of e^-50, and of e^-12 then.
constexpr double kOutOfTheQuestion_chi2 = 100;
/// Two readings nearer to each other than this are one, as in pose/mirror_image.h. [rad]
constexpr double kSamePose_rad = 0.005;
/// A step that moves no dot of a landmark a metre away by more than a ten thousandth of a pixel. [m, rad]
constexpr double kNegligible = 1e-8;

/// For levenberg_marquardt().
struct CameraProblem {
  using State = WorldFromCamera;
  static constexpr int kUnknowns = 6;

  std::span<const PlacedSighting> sightings;
  const LandmarkGeometry& landmark;

  SightingFit fit(const State& T_world_camera) const noexcept {
    SightingFit sum;
    for (const PlacedSighting& placed : sightings)
      sum += fit_of_sighting(*placed.seen, placed.T_world_landmark, T_world_camera, landmark);
    return sum;
  }
  double linearise(const State& at, PoseInformation& normal, PoseStep& gradient) const noexcept {
    const SightingFit sum = fit(at);
    normal = sum.normal;
    gradient = sum.gradient;
    return sum.chi2;
  }
  double cost(const State& at) const noexcept { return fit(at).chi2; }
  static State moved(const State& at, const PoseStep& step) noexcept { return moved_by(at, step); }
  static bool is_negligible(const State& /*at*/, const PoseStep& step) noexcept {
    return step.lpNorm<Eigen::Infinity>() < kNegligible;
  }
};

/// As the closed form takes them: one weight for both directions of a dot.
InlineVector<PlanePoint, kDotCount> plane_points(const LandmarkSighting& sighting, const LandmarkGeometry& landmark) {
  InlineVector<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const DotSighting& seen = sighting.dots[dot];
    if (seen.information.isZero(0)) continue;
    static_cast<void>(points.try_push_back({landmark.centre_m(dot), seen.ray, seen.information.trace() / 2}));
  }
  return points;
}

bool is_same(const CameraFromLandmark& a, const CameraFromLandmark& b) {
  return log_so3(a.rotation.transpose() * b.rotation).norm() < kSamePose_rad;
}

}  // namespace

CameraFit fit_camera(std::span<const PlacedSighting> sightings, const WorldFromCamera& start,
                     const LandmarkGeometry& landmark) noexcept {
  const CameraProblem problem{sightings, landmark};
  CameraFit result{start, 0};
  levenberg_marquardt(problem, result.T_world_camera);
  result.chi2 = problem.cost(result.T_world_camera);
  return result;
}

OwnPoses own_poses(const LandmarkSighting& sighting, const LandmarkGeometry& landmark) noexcept {
  const InlineVector<PlanePoint, kDotCount> points = plane_points(sighting, landmark);
  const Result<PlanarPoses> closed_form = solve_planar_pose(points.span());
  if (!closed_form) return {};
  // The landmark's own frame takes the world's place.
  const PlacedSighting placed{&sighting, {}};
  InlineVector<OwnPose, 3> found;
  for (const CameraFromLandmark& start :
       {sighting.T_camera_landmark, (*closed_form)[0].T_camera_landmark, (*closed_form)[1].T_camera_landmark}) {
    const CameraFromLandmark camera_start = start;
    const WorldFromCamera T_world_camera{camera_start.rotation.transpose(), camera_start.inverse().translation_m};
    const CameraFit fit = fit_camera({&placed, 1}, T_world_camera, landmark);
    const CameraFromLandmark T{fit.T_world_camera.rotation.transpose(), fit.T_world_camera.inverse().translation_m};
    if (!std::isfinite(fit.chi2) || fit.T_world_camera.translation_m.y() <= 0) continue;
    if (std::ranges::any_of(found, [&](const OwnPose& pose) { return is_same(pose.T_camera_landmark, T); })) continue;
    const SightingFit at = fit_of_sighting(sighting, placed.T_world_landmark, fit.T_world_camera, landmark);
    const PoseInformation covariance = at.normal.inverse();
    if (covariance.allFinite()) static_cast<void>(found.try_push_back({T, fit.chi2, covariance}));
  }
  if (found.empty()) return {};
  OwnPose* const best = std::ranges::min_element(found, {}, &OwnPose::chi2);
  std::swap(found[0], *best);
  OwnPoses result;
  for (const OwnPose& pose : found)
    if (pose.chi2 - found[0].chi2 < kOutOfTheQuestion_chi2) static_cast<void>(result.try_push_back(pose));
  return result;
}

}  // namespace ninedot
