#pragma once
/// Finds the landmarks in a picture.
#include <cstdint>
#include <memory>
#include <span>

#include "base/result.h"
#include "detect/forecast.h"
#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "image/image_view.h"

namespace ninedot {

struct DetectorOptions {
  double expected_roll_rad = 0;  ///< roll of the camera about its optical axis at which P1 is the lowest dot
};

/// What found no room in a list of fixed size and was left out, since the detector was made. Each counts one thing left
/// out, not one picture, and wraps at 2^32. All were 0 over the recordings that show a landmark; twenty look-alikes
/// without one (rings, grids, wallpaper) had 0, 151, 1105 and 1655, for then every guess is tried.
struct DetectorCounts {
  std::uint32_t runs_cut = 0;        ///< dark stretches of a row, from the bottom of the picture (RegionFinder)
  std::uint32_t blobs_cut = 0;       ///< dark spots: more than kMaxBlobs (BlobFinder)
  std::uint32_t neighbours_cut = 0;  ///< spots around one that may be P9, or beside one on the ring (hypothesis.h)
  std::uint32_t hypotheses_cut = 0;  ///< guesses: more than kMaxHypotheses, those with fewer dots left out
  std::uint32_t landmarks_cut = 0;   ///< landmarks: more than kMaxLandmarksInView
};

/// Memory: everything is allocated by the constructor for the camera's picture size. Threads: one caller.
class Detector {
 public:
  Detector(const CameraModel& camera, const LandmarkGeometry& landmark, const DetectorOptions& options = {});
  ~Detector();
  Detector(const Detector&) = delete;
  Detector& operator=(const Detector&) = delete;

  /// Searches the whole picture. Dots are numbered by the priors (numbering.h).
  /// \param luma  of the camera's size, else kFrameSize
  /// \return  what was found, the surest first: at least one, at present at most one, never more than
  /// kMaxLandmarksInView. Valid until the next call of a find function.
  /// \error kNoLandmark: nothing in the picture is one; kPoseDegenerate: its visible dots lie on a line or where the
  /// lens's model has no inverse; kFrameSize
  Result<std::span<const LandmarkObservation>> find_landmarks(const ImageView& luma) noexcept;

  /// Looks only where the landmark is expected; cheaper by far.
  /// \param expected  its pose (a CameraFromLandmark will do), or as it was seen in the frame before, or moved to where
  /// it should be now. Where the forecast is numbered, the dots keep its numbers.
  /// \error kNoLandmark: not there (it may still be elsewhere); kPoseDegenerate, kFrameSize: as above
  Result<LandmarkObservation> find_landmark_near(const ImageView& luma, const LandmarkForecast& expected) noexcept;

  DetectorCounts counts() const noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace ninedot
