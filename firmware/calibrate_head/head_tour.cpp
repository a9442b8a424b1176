#include "calibrate_head/head_tour.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "calibrate_head/head_sufficiency.h"

namespace ninedot {
namespace {

/// As many pictures that agree: three are needed (head_stops.cpp), and one may be misread.
constexpr int kSteadyPictures = 5;
/// Two thirds of a stop's pictures must agree: who came to rest late stays longer.
constexpr double kSteadyShare = 0.7;
/// From one picture to the next, at rest: below half of what head_stops.cpp lets pass.
constexpr double kSteady = 5e-4;
/// So many without a landmark, and there is none; so many that do not settle, and they never will.
constexpr int kEmptyPictures = 5, kMostPictures = 120;
/// Of what is to one side of the picture's middle: a step outwards, and from one direction of the search to the next.
constexpr double kReachStep = 1.0 / 6, kFindStep = 1.2;

double HeadAngles::*const kAxes[] = {&HeadAngles::pan_rad, &HeadAngles::tilt_rad};

/// The ends too: what is to see beyond them is seen from there.
std::vector<double> steps_between(double low, double high, double middle, double step) {
  std::vector<double> places{middle};
  for (double at = middle; at < high;) places.push_back(at = std::min(high, at + step));
  for (double at = middle; at > low;) places.push_back(at = std::max(low, at - step));
  return places;
}

}  // namespace

HeadTour::HeadTour(const HeadTourOptions& options) : options_(options), goal_(options.start) {
  EXPECTS(options.half_width_rad > 0 && options.half_height_rad > 0 && options.columns >= 2 && options.rows >= 2);
  for (const double tilt : steps_between(options.min.tilt_rad, options.max.tilt_rad, options.start.tilt_rad,
                                         kFindStep * options.half_height_rad))
    for (const double pan : steps_between(options.min.pan_rad, options.max.pan_rad, options.start.pan_rad,
                                          kFindStep * options.half_width_rad))
      way_.push_back({pan, tilt});
  std::ranges::stable_sort(way_, {}, [&](const HeadAngles& at) {
    return std::hypot(at.pan_rad - options.start.pan_rad, at.tilt_rad - options.start.tilt_rad);
  });
}

bool HeadTour::look(const std::optional<Eigen::Vector2d>& direction) {
  if (part_ == Part::kHome) return false;
  ++looks_;
  if (direction) {
    ++sights_;
    steady_ = steady_ > 0 && (*direction - before_).norm() < kSteady ? steady_ + 1 : 1;
    before_ = *direction;
  }
  const bool is_steady = steady_ >= kSteadyPictures && steady_ >= kSteadyShare * sights_;
  const bool is_empty = sights_ == 0 && looks_ >= kEmptyPictures;
  if (!is_steady && !is_empty && looks_ < kMostPictures) return false;
  advance(sights_ > 0);
  return true;
}

void HeadTour::advance(bool is_seen) {
  looks_ = sights_ = steady_ = 0;
  ++made_;
  switch (part_) {
    case Part::kFind:
      return go_on_finding(is_seen);
    case Part::kReach:
      return go_on_reaching(is_seen);
    case Part::kGrid:
      if (++next_ < way_.size()) {
        goal_ = way_[next_];
        return;
      }
      part_ = Part::kHome;
      goal_ = options_.home;
      return;
    case Part::kHome:
      return;
  }
}

void HeadTour::go_on_finding(bool is_seen) {
  if (is_seen) return begin_reach();
  if (++next_ < way_.size()) {
    goal_ = way_[next_];
    return;
  }
  part_ = Part::kHome;
  goal_ = options_.home;
}

void HeadTour::begin_reach() {
  part_ = Part::kReach;
  base_ = low_ = high_ = goal_;
  side_ = 0;
  try_next_side();
}

/// The sides in turn: pan up, pan down, tilt up, tilt down.
void HeadTour::try_next_side() {
  for (; side_ < 4; ++side_) {
    // Tilt is tried where pan has most to both sides.
    if (side_ == 2) base_.pan_rad = (low_.pan_rad + high_.pan_rad) / 2;
    goal_ = base_;
    if (step_out()) return;
  }
  begin_grid();
}

/// \return  false: the limit is reached
bool HeadTour::step_out() {
  double HeadAngles::*const axis = kAxes[side_ / 2];
  const double step = kReachStep * (side_ < 2 ? options_.half_width_rad : options_.half_height_rad);
  const double before = goal_.*axis;
  goal_.*axis = std::clamp(before + (side_ % 2 == 0 ? step : -step), options_.min.*axis, options_.max.*axis);
  return goal_.*axis != before;
}

void HeadTour::go_on_reaching(bool is_seen) {
  double HeadAngles::*const axis = kAxes[side_ / 2];
  if (is_seen) {
    low_.*axis = std::min(low_.*axis, goal_.*axis);
    high_.*axis = std::max(high_.*axis, goal_.*axis);
    if (step_out()) return;
  }
  ++side_;
  try_next_side();
}

void HeadTour::begin_grid() {
  part_ = Part::kHome;
  goal_ = options_.home;
  if (high_.pan_rad - low_.pan_rad < kLeastTravel_rad || high_.tilt_rad - low_.tilt_rad < kLeastTravel_rad) return;
  part_ = Part::kGrid;
  way_.clear();
  next_ = 0;
  // No place twice: what a servo's steps or a bent gear err by at one place would count as if it were new each time. So
  // rows are shifted against each other, and on the way back they lie between those of the way there.
  constexpr double kGolden = 0.6180339887498949;  // shifts that never repeat (H. Weyl, Math. Annalen 77 (1916))
  const double width = high_.pan_rad - low_.pan_rad, height = high_.tilt_rad - low_.tilt_rad;
  int row = 0;
  for (const bool is_back : {false, true}) {
    const int rows = is_back ? options_.rows - 1 : options_.rows;
    for (int r = 0; r < rows; ++r, ++row) {
      const double up = is_back ? options_.rows - 1.5 - r : r;
      const double shift = std::fmod(kGolden * (row + 0.5), 1.0);
      for (int c = 0; c < options_.columns; ++c) {
        const double across = (row % 2 == 0 ? c : options_.columns - 1 - c) + shift;
        way_.push_back(
            {low_.pan_rad + width * across / options_.columns, low_.tilt_rad + height * up / (options_.rows - 1)});
      }
    }
  }
  planned_ = made_ + way_.size();
  goal_ = way_.front();
}

}  // namespace ninedot
