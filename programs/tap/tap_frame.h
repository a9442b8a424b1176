#pragma once
/// Between what the program knows of a frame, in metres and radians, and what the tap says of it, in mm and degrees.
#include <optional>

#include "detect/failed_search.h"
#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "image/frame.h"
#include "pipeline/frame_processor.h"
#include "proto/tap_layout.h"
#include "report/report.h"

namespace ninedot {

/// Fills all of `tap` but its picture, its latency bins and its search. \param seen  the dots; null: none
/// Memory: none. Threads: pure; the frame loop's.
void describe_frame(const Frame& frame, const Fix& fix, const LandmarkObservation* seen, const Report& report,
                    TapFrame& tap) noexcept;

/// Fills its search: why nothing was found; none: that is not so. Memory: none. Threads: pure; the frame loop's.
void describe_search(const std::optional<FailedSearch>& failed, TapFrame& tap) noexcept;

/// What of the report is in the tap, for who draws it: the pose with the variances of its covariance.
Report report_of(const TapFrame& tap) noexcept;
/// The dots that the pose rests on. \return  whether there were any
bool observation_of(const TapFrame& tap, LandmarkObservation& seen) noexcept;

/// Its search again. \param spots  filled: what the answer refers to \return  none: it did not fail
std::optional<FailedSearch> search_of(const TapFrame& tap, BlobList& spots) noexcept;

/// Into and out of the tap's header.
void describe_camera(const CameraModel& camera, const LandmarkGeometry& landmark, TapHeader& header) noexcept;
CameraModel camera_of(const TapHeader& header) noexcept;
LandmarkGeometry landmark_of(const TapHeader& header) noexcept;

}  // namespace ninedot
