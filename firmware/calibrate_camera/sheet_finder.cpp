#include "calibrate_camera/sheet_finder.h"

#include "detect/work_budget.h"

namespace ninedot {
namespace {

/// A dot of which less is seen has its centroid elsewhere.
constexpr float kWhole = 0.9F;
/// There is time: ten times what a frame of the service may cost.
constexpr int kPatience = 10;

}  // namespace

LandmarkFinder::LandmarkFinder(const CameraModel& guess, const LandmarkGeometry& landmark)
    : detector_(guess, landmark) {}

std::vector<SeenDisc> LandmarkFinder::find(const ImageView& luma) {
  WorkBudget budget;
  budget.regions *= kPatience, budget.guesses *= kPatience;
  const auto found = detector_.find_landmarks(luma, budget);
  std::vector<SeenDisc> seen;
  if (!found || found->empty()) return seen;
  const LandmarkObservation& landmark = found->front();
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (landmark.dots[dot].seen && landmark.dots[dot].visible_fraction > kWhole)
      seen.push_back({dot, landmark.dots[dot].centroid_px});
  if (seen.size() < 5) seen.clear();  // what a homography needs
  return seen;
}

CameraModel usual_camera(int width_px, int height_px) {
  CameraModel camera;
  camera.width_px = width_px, camera.height_px = height_px;
  camera.fx_px = camera.fy_px = width_px;  // 53 degrees across
  camera.cx_px = 0.5 * (width_px - 1), camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

}  // namespace ninedot
