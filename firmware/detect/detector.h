#pragma once
/// Finds the landmarks in a picture.
#include <memory>
#include <optional>
#include <span>

#include "base/result.h"
#include "base/work_counts.h"
#include "detect/failed_search.h"
#include "detect/forecast.h"
#include "detect/observation.h"
#include "detect/work_budget.h"
#include "geometry/camera_model.h"
#include "geometry/upright_prior.h"
#include "image/image_view.h"

namespace ninedot {

struct DetectorOptions {
  UprightPrior upright{};  ///< how the camera is mounted
};

/// What a picture may cost is bounded by a WorkBudget. A picture that has more in it is searched in part, and the next
/// one's search begins where this one's ended: only then does an answer depend on the pictures before it.
/// Memory: everything is allocated by the constructor for the camera's picture size. Threads: one caller.
class Detector {
 public:
  Detector(const CameraModel& camera, const LandmarkGeometry& landmark, const DetectorOptions& options = {});
  ~Detector();
  Detector(const Detector&) = delete;
  Detector& operator=(const Detector&) = delete;

  /// Searches the whole picture. Dots are numbered by the priors (numbering.h).
  /// \param luma  of the camera's size, else kFrameSize
  /// \param budget  what is left for this picture
  /// \return  the surest, alone. Valid until the next call of a find function.
  /// \error kNoLandmark: nothing in the picture is one; kPoseDegenerate: its visible dots lie on a line or where the
  /// lens's model has no inverse; kFrameSize
  Result<std::span<const LandmarkObservation>> find_landmarks(const ImageView& luma, WorkBudget& budget) noexcept;

  /// The same without mercy, for when what was found turned out to be none: all levels, all kinds of guesses.
  /// \param luma  the picture that find_landmarks was asked about last (contract)
  /// \return  up to kMaxGuesses that the grey levels around their outlines don't refute, the surest first; they may be
  /// different readings of the same blobs. Valid until the next call of a find function.
  /// \error  as above
  Result<std::span<const LandmarkObservation>> find_more_landmarks(const ImageView& luma, WorkBudget& budget) noexcept;
  static constexpr std::size_t kMaxGuesses = 6;

  /// Searches the whole picture for all landmarks whose P9 is in sight, at every size.
  /// \return  those that the grey levels confirm, each once, the surest first. Valid until the next call of a find
  /// function. \error as find_landmarks
  Result<std::span<const LandmarkObservation>> find_all_landmarks(const ImageView& luma, WorkBudget& budget) noexcept;

  /// Looks only where the landmark is expected; cheaper by far.
  /// \param expected  its pose (a CameraFromLandmark will do), or as it was seen in the frame before, or moved to where
  /// it should be now. Where the forecast is numbered, the dots keep its numbers.
  /// \error kNoLandmark: not there (it may still be elsewhere); kPoseDegenerate, kFrameSize: as above
  Result<LandmarkObservation> find_landmark_near(const ImageView& luma, const LandmarkForecast& expected,
                                                 WorkBudget& budget) noexcept;

  // A picture looked at once has a budget of its own.
  Result<std::span<const LandmarkObservation>> find_landmarks(const ImageView& luma) noexcept {
    WorkBudget budget;
    return find_landmarks(luma, budget);
  }
  Result<LandmarkObservation> find_landmark_near(const ImageView& luma, const LandmarkForecast& expected) noexcept {
    WorkBudget budget;
    return find_landmark_near(luma, expected, budget);
  }

  /// Of the last find_landmarks that found nothing: three dots in a row of a landmark's ring, where the rest of it may
  /// be hidden, and nothing more. To show, not to act on. None: there are none. Memory: none.
  std::optional<LandmarkObservation> three_dots() const noexcept;

  /// Of the last search of a whole picture that found nothing. Asking costs a microsecond, and nothing unless asked.
  FailedSearch failed_search() const noexcept;

  /// What was left out since the detector was made.
  WorkCounts counts() const noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace ninedot
