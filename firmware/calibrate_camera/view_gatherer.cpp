#include "calibrate_camera/view_gatherer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "calibrate_camera/edge_points.h"

namespace ninedot {
namespace {

/// From one picture to the next, in widths of the picture: 0.4 px of 640. While a frame is exposed and read out the
/// sheet moves by no more than that, so neither blur nor shear is larger; a hand that holds still moves it by half as
/// much.
constexpr double kStill_widths = 1.0 / 1600;
/// So often in a row: a hand that turns round stands still for one picture.
constexpr int kStillPictures = 2;

/// Mean distance from each dot to the nearest of the picture before: a black-and-white landmark may be numbered anew
/// from picture to picture, since turned by a dot it looks the same. Infinite: there is none. [px]
double moved_px(std::span<const SeenDisc> before, std::span<const SeenDisc> now) {
  if (before.empty() || now.empty()) return std::numeric_limits<double>::infinity();
  double sum_px = 0;
  for (const SeenDisc& disc : now) {
    double nearest_px = std::numeric_limits<double>::infinity();
    for (const SeenDisc& other : before) nearest_px = std::min(nearest_px, (disc.centre_px - other.centre_px).norm());
    sum_px += nearest_px;
  }
  return sum_px / static_cast<double>(now.size());
}

}  // namespace

ViewGatherer::ViewGatherer(int width_px, std::span<const PlaneDisc> discs)
    : still_px_(kStill_widths * width_px), discs_(discs), views_(width_px) {}

Looked ViewGatherer::look(SheetFinder& finder, const ImageView& luma, SensorKind sensor) {
  SheetView view;
  view.seen = finder.find(luma);
  still_ = moved_px(newest_, view.seen) <= still_px_ ? still_ + 1 : 0;
  newest_ = view.seen;
  if (view.seen.empty()) return Looked::kNoSheet;
  ++found_;
  if (still_ < kStillPictures) return Looked::kMoving;
  if (!views_.is_new(view)) return Looked::kSeenBefore;
  view = keep_view(luma, sensor, std::move(view.seen), discs_);
  const MeasuredOutlines outlines = measure_edges(view, expected_by_homography(view, discs_), discs_);
  if (outlines.edges.size() < kLeastEdges || outlines.blur_px > kSharp_px) return Looked::kBlurred;
  view.frame = found_;
  views_.add(std::move(view));
  return Looked::kTaken;
}

}  // namespace ninedot
