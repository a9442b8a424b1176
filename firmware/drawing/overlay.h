#pragma once
/// Pictures that show what was found in a frame and how well: for people, made by `ninedot replay --overlay`.
#include <cstdint>
#include <vector>

#include "detect/failed_search.h"
#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "image/image_view.h"
#include "report/report.h"

namespace ninedot {

/// 8-bit RGB, row by row without padding: 3 * width_px bytes from one row to the next.
struct RgbPicture {
  std::vector<std::uint8_t> pixels;
  int width_px = 0;
  int height_px = 0;
};

/// The enlargement at which lines and text over a frame of this height are crisp: the smallest that gives 900 rows, at
/// least 1, at most 8.
int overlay_scale(int height_px) noexcept;

/// Enlarges the frame by `scale` and draws into it, with a panel of numbers beside it.
///
/// In the frame, when the pose is valid: the outline of each disc as the pose projects it through the whole camera
/// model (dashed where the dot was not seen), the ring, the axes X0 Y0 Z0 of the landmark, and the labels P1..P9; a
/// cross at each observed centroid. In the panel: position with 1-sigma, distance, angles, dots, residual, ambiguity,
/// time; a magnified cut-out when the landmark spans less than 100 px. When nothing was found: the reason, the dark
/// spots that the search saw, and the dots of the guess that came nearest to a landmark, dashed where there is none.
///
/// \param luma      the frame that `report` is about; not empty (contract).
/// \param seen      the dots that the pose rests on, px of the frame; null when none were found.
/// \param failed    what the search saw that found nothing; null: it found something, or there was none.
/// \param camera    of the frame. \param geometry  of the landmark [m].
/// \param scale     output pixels per frame pixel, > 0 (contract), or 0 for overlay_scale of the frame's height.
/// \param picture   filled; its memory is used again, so one picture serves a whole recording. Its size depends only on
///                  the frame's size and on `scale`.
/// Memory: allocates; not for the frame path. Threads: any, one per picture; switches OpenCV's worker threads off in
/// this process.
void draw_overlay(const ImageView& luma, const Report& report, const LandmarkObservation* seen,
                  const FailedSearch* failed, const CameraModel& camera, const LandmarkGeometry& geometry, int scale,
                  RgbPicture& picture);

}  // namespace ninedot
