#pragma once
/// Finds a calibration's sheet in a picture by a lens that nobody knows yet.
#include <memory>
#include <vector>

#include "calibrate_camera/sheet_view.h"
#include "detect/detector.h"
#include "geometry/camera_model.h"

namespace ninedot {

/// Threads: one caller.
class SheetFinder {
 public:
  SheetFinder() = default;
  virtual ~SheetFinder() = default;
  SheetFinder(const SheetFinder&) = delete;
  SheetFinder& operator=(const SheetFinder&) = delete;

  /// \return  the discs that are seen whole; none: the sheet is not in the picture
  virtual std::vector<SeenDisc> find(const ImageView& luma) = 0;
};

/// The nine-dot landmark. Its numbering is left to the detector's priors: turned by a dot it looks the same, and a lens
/// cares for no more.
class LandmarkFinder final : public SheetFinder {
 public:
  /// \param guess  of the lens, for pictures of its size; a wrong one costs some views, not their accuracy
  LandmarkFinder(const CameraModel& guess, const LandmarkGeometry& landmark);
  std::vector<SeenDisc> find(const ImageView& luma) override;

 private:
  Detector detector_;
};

/// A lens without distortion and of a usual focal length, for pictures of this size.
CameraModel usual_camera(int width_px, int height_px);

}  // namespace ninedot
