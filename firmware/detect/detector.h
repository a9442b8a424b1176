#pragma once
/// Finds the landmark in a picture.
#include <memory>

#include "base/result.h"
#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "image/image_view.h"

namespace ninedot {

struct DetectorOptions {
  double expected_roll_rad = 0;  ///< roll of the camera about its optical axis at which P1 is the lowest dot
};

/// Memory: everything is allocated by the constructor for the camera's picture size. Threads: one caller.
class Detector {
 public:
  Detector(const CameraModel& camera, const LandmarkGeometry& landmark, const DetectorOptions& options = {});
  ~Detector();
  Detector(const Detector&) = delete;
  Detector& operator=(const Detector&) = delete;

  /// Searches the whole picture.
  /// \param luma  of the camera's size, else kFrameSize
  /// \error kNoLandmark, kFrameSize
  Result<LandmarkObservation> find_landmark(const ImageView& luma) noexcept;

  /// Looks only where the landmark is expected; cheaper by far.
  /// \param predicted  the landmark in the frame before, or moved to where it should be now
  /// \error kNoLandmark: not there (it may still be elsewhere); kFrameSize
  Result<LandmarkObservation> find_landmark_near(const ImageView& luma, const LandmarkObservation& predicted) noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace ninedot
