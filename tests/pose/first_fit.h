#pragma once
/// What the detector's first guess in a picture leads to.
#include <cstdint>
#include <optional>

#include "detect/detector.h"
#include "pose/full_solver.h"
#include "tests/support/renderer.h"

namespace ninedot::test {

/// Likeliest pose; nothing where the guess leads to none.
inline std::optional<PoseCandidate> first_fit(const ImageView& picture) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture);
  if (!seen) return std::nullopt;
  FullSolver solver(CameraModel{}, LandmarkGeometry{});
  int pixels = 100'000;
  const auto answer = solver.solve(picture, seen->front(), nullptr, pixels);
  if (!answer) return std::nullopt;
  return answer->list[0];
}

/// One sheet, seen from there, with the noise of a usual camera.
inline Scene scene_of(const Sheet& sheet, const Viewpoint& viewpoint) {
  Scene scene;
  scene.camera = look_at_landmark(viewpoint);
  scene.sheets = {sheet};
  set_noise(scene.sensor, 1.5);
  return scene;
}

}  // namespace ninedot::test
