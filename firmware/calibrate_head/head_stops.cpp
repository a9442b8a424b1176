// A run of pictures with the same told angles is a stop, from a while after its beginning on. In it the landmark is
// looked at: pictures that show it where most of them do are averaged, dot by dot.
#include "calibrate_head/head_stops.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "base/median.h"
#include "base/units.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// Heads that tell where they are say one step more or less now and then: the coarsest one's is 0.114 deg
/// (aim/arrival.h).
constexpr double kSameAngle_rad = 0.15 * kRadPerDeg;
/// Where a stop's last pictures differ by more from its first ones, the head is on its way to the next.
constexpr double kLeaving_rad = 0.02 * kRadPerDeg;
/// A servo is this late at most where nobody told of it (docs/pan-tilt.md: 100 ms of a VISCA camera), and swings out.
constexpr auto kSettle = 300ms;
/// With fewer nobody can tell which of them is off.
constexpr std::size_t kLeastPictures = 3;
/// Ten times what a dot's place is uncertain by in one picture, a twentieth of a degree.
constexpr double kSteady = 1e-3;
/// Of a picture's variance, what it shares with the next one where head and camera stand: more than `common_share` of
/// [track] says of a camera that moves.
constexpr double kCommonShare = 0.5;

bool is_same(const HeadAngles& a, const HeadAngles& b, double to_rad) {
  return std::abs(a.pan_rad - b.pan_rad) < to_rad && std::abs(a.tilt_rad - b.tilt_rad) < to_rad;
}

Eigen::Vector2d direction_of(const LandmarkSighting& sighting) {
  return sighting.T_camera_landmark.translation_m.hnormalized();
}

/// All dots that both show are in one place: also another numbering of the same dots is told apart.
bool shows_the_same(const LandmarkSighting& a, const LandmarkSighting& b) {
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (a.dots[dot].information.isZero(0) || b.dots[dot].information.isZero(0)) continue;
    if ((a.dots[dot].ray - b.dots[dot].ray).norm() > 2 * kSteady) return false;
  }
  return true;
}

/// The mean of pictures that show the same. \param kept  not empty
LandmarkSighting mean_of(const std::vector<const LandmarkSighting*>& kept, const LandmarkSighting& middle) {
  LandmarkSighting mean{middle.id, middle.T_camera_landmark, {}};
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
    double count = 0;
    for (const LandmarkSighting* seen : kept) {
      const DotSighting& one = seen->dots[dot];
      if (one.information.isZero(0)) continue;
      sum += one.information, weighted += one.information * one.ray, ++count;
    }
    if (2 * count < static_cast<double>(kept.size())) continue;  // hidden most of the time
    mean.dots[dot].ray = sum.inverse() * weighted;
    mean.dots[dot].information = sum / count / (kCommonShare + (1 - kCommonShare) / count);
  }
  return mean;
}

/// One landmark in the pictures of a stop. A servo may come to rest late, so the later half says where it stands.
/// \return  none: it did not stand still then either
std::optional<LandmarkSighting> steady_sighting(const std::vector<const LandmarkSighting*>& seen) {
  const auto later = std::span(seen).last(std::max(kLeastPictures, (seen.size() + 1) / 2));
  std::vector<double> x, y;
  for (const LandmarkSighting* one : later) x.push_back(direction_of(*one).x()), y.push_back(direction_of(*one).y());
  const Eigen::Vector2d middle(median(x), median(y));
  const auto off = [&](const LandmarkSighting* one) { return (direction_of(*one) - middle).norm(); };
  const LandmarkSighting& nearest = **std::ranges::min_element(later, {}, off);
  const auto is_steady = [&](const LandmarkSighting* one) {
    return off(one) < kSteady && shows_the_same(*one, nearest);
  };
  const auto steady = static_cast<std::size_t>(std::ranges::count_if(later, is_steady));
  if (steady < kLeastPictures || 3 * steady < 2 * later.size()) return std::nullopt;
  std::vector<const LandmarkSighting*> kept;
  std::ranges::copy_if(seen, std::back_inserter(kept), is_steady);
  return mean_of(kept, nearest);
}

/// From where an axis came.
class AxisSide {
 public:
  void begin(double told_rad) { turned_rad_ = told_rad, side_ = 0; }
  void follow(double told_rad) {
    if (std::abs(told_rad - turned_rad_) < kSameAngle_rad) return;
    side_ = told_rad > turned_rad_ ? 1 : -1;
    turned_rad_ = told_rad;
  }
  int side() const { return side_; }

 private:
  double turned_rad_ = 0;
  int side_ = 0;
};

/// Takes the pictures in order.
class StopFinder {
 public:
  explicit StopFinder(FoundStops& found) : found_(found) {}

  void take(const HeadFrame& frame) {
    const bool begins = run_.empty() || run_.front()->recording != frame.recording;
    if (begins || !is_same(run_.front()->told, frame.told, kSameAngle_rad)) finish();
    if (begins) pan_.begin(frame.told.pan_rad), tilt_.begin(frame.told.tilt_rad);
    pan_.follow(frame.told.pan_rad), tilt_.follow(frame.told.tilt_rad);
    run_.push_back(&frame);
  }

  void finish() {
    std::vector<const HeadFrame*> settled;
    for (const HeadFrame* frame : run_)
      if (frame->exposed_at - run_.front()->exposed_at >= kSettle) settled.push_back(frame);
    run_.clear();
    while (!settled.empty() && !is_same(settled.front()->told, settled.back()->told, kLeaving_rad)) settled.pop_back();
    if (settled.size() < kLeastPictures) return;
    HeadStop stop{settled.front()->recording, {}, pan_.side(), tilt_.side(), {}};
    std::map<std::uint16_t, std::vector<const LandmarkSighting*>> by_id;
    for (const HeadFrame* frame : settled) {
      stop.told.pan_rad += frame->told.pan_rad / static_cast<double>(settled.size());
      stop.told.tilt_rad += frame->told.tilt_rad / static_cast<double>(settled.size());
      for (const LandmarkSighting& sighting : frame->seen) by_id[sighting.id].push_back(&sighting);
    }
    bool has_moved = false;
    for (const auto& [id, seen] : by_id) {
      if (seen.size() < kLeastPictures) continue;
      if (const auto steady = steady_sighting(seen))
        stop.seen.push_back(*steady);
      else
        has_moved = true;
    }
    if (!stop.seen.empty())
      found_.stops.push_back(std::move(stop));
    else
      ++(has_moved ? found_.unsteady : found_.without_landmark);
  }

 private:
  FoundStops& found_;
  std::vector<const HeadFrame*> run_;
  AxisSide pan_, tilt_;
};

}  // namespace

FoundStops find_stops(std::span<const HeadFrame> frames) {
  FoundStops found;
  if (frames.empty()) return found;
  found.told_min = found.told_max = frames.front().told;
  StopFinder finder(found);
  for (const HeadFrame& frame : frames) {
    found.told_min.pan_rad = std::min(found.told_min.pan_rad, frame.told.pan_rad);
    found.told_min.tilt_rad = std::min(found.told_min.tilt_rad, frame.told.tilt_rad);
    found.told_max.pan_rad = std::max(found.told_max.pan_rad, frame.told.pan_rad);
    found.told_max.tilt_rad = std::max(found.told_max.tilt_rad, frame.told.tilt_rad);
    finder.take(frame);
  }
  finder.finish();
  return found;
}

}  // namespace ninedot
