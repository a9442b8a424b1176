#include "detect/hypothesis.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "detect/blob_moments.h"
#include "detect/homography.h"
#include "detect/work_budget.h"

namespace ninedot {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSlot_rad = kPi / 4;  // between neighbours on the ring
// How far the ring's dots may be from where P9's ellipse has them: a quarter of a slot, a third of the ring's radius,
// and a factor of their area. Perspective at 0.5 m and 75 degrees, and blur at 5 m, take a quarter of the first and
// three quarters of the others: detect_test --gtest_filter='DetectorConstants.*' measures each.
constexpr double kSlotTolerance_rad = kPi / 16;
constexpr double kRadiusTolerance = 0.32;
constexpr double kAreaTolerance = 2.2;
constexpr std::size_t kMaxNeighbours = 24;  // three times the ring's eight: what else is as large and as near
// Of small blobs, measured by grey levels: point spread (0.6 px)^2 and the pixel's own 1/12, in units of the level's
// pixels.
constexpr float kBlur_px2 = 0.44F;
// Of the correlation of x and y that is left after the blur was taken off: axes of 1 to 0.1 at 45 degrees.
constexpr float kMostEccentric = 0.98F;
constexpr float kSmallArea_px2 = 120;  // as in blob_moments.cpp: below, grey levels are measured

/// Turns px into units in which a blob's outline is a circle of radius 1 around it. Cholesky: keeps the orientation.
class Whitening {
 public:
  explicit Whitening(const Blob& blob) noexcept : x_(blob.x_px), y_(blob.y_px) {
    const float scale2 = blob.level < 0 ? 0.25F : static_cast<float>(1 << (2 * blob.level));
    const float blur = blob.area_px2 < kSmallArea_px2 * scale2 ? kBlur_px2 * scale2 : 0;
    // A blob has at least a pixel's variance: the floor only keeps what is none from making roots of negative numbers.
    const float floor = 0.25F * static_cast<float>(kPixelVariance_px2);
    const float xx = std::max({blob.xx_px2 - blur, 0.25F * blob.xx_px2, floor});
    const float yy = std::max({blob.yy_px2 - blur, 0.25F * blob.yy_px2, floor});
    const float limit = kMostEccentric * std::sqrt(xx * yy);
    const float xy = std::clamp(blob.xy_px2, -limit, limit);
    l00_ = std::sqrt(xx);
    l10_ = xy / l00_;
    l11_ = std::sqrt(yy - l10_ * l10_);
  }
  /// M = L L^T and a disc of radius r has M = r^2 / 4: hence the half.
  Eigen::Vector2f operator()(float x_px, float y_px) const noexcept {
    const float a = (x_px - x_) / l00_;
    return {0.5F * a, 0.5F * (y_px - y_ - l10_ * a) / l11_};
  }

 private:
  float x_, y_, l00_, l10_, l11_;
};

/// 1 where the blob's second moments are the predicted ones, more for another size, axis ratio or direction: half the
/// trace of M^-1 M' after both are scaled to the same area.
double shape_mismatch(const Blob& blob, const Eigen::Matrix2d& predicted_px2) noexcept {
  const double xx = blob.xx_px2, xy = blob.xy_px2, yy = blob.yy_px2;
  const double det = std::max(xx * yy - xy * xy, 1e-6);
  const double trace = yy * predicted_px2(0, 0) - 2 * xy * predicted_px2(0, 1) + xx * predicted_px2(1, 1);
  return 0.5 * trace / std::sqrt(det * std::max(predicted_px2.determinant(), 1e-12));
}

struct Neighbour {
  std::int16_t blob;
  float angle_rad;
  float radius_error;  // relative
};
using NeighbourList = InlineVector<Neighbour, kMaxNeighbours>;

void find_ring_around(const SortedBlobs& blobs, std::size_t centre, const LandmarkGeometry& landmark,
                      NeighbourList& out, GuessCuts& cuts) noexcept {
  const Blob& c = blobs.list()[centre];
  const Whitening whiten(c);
  const double area_ratio = std::pow(landmark.dot_radius_m / landmark.centre_radius_m, 2);
  const auto ring = static_cast<float>(landmark.ring_radius_m / landmark.centre_radius_m);
  const float reach_px = c.semi_major_px() * ring * static_cast<float>(1 + kRadiusTolerance);
  out.clear();
  blobs.for_each_near(c.x_px, c.y_px, reach_px, c.area_px2 * area_ratio / kAreaTolerance,
                      c.area_px2 * area_ratio * kAreaTolerance, [&](std::size_t i, const Blob& blob) {
                        const Eigen::Vector2f n = whiten(blob.x_px, blob.y_px);
                        const float error = n.norm() / ring - 1;
                        if (std::abs(error) > static_cast<float>(kRadiusTolerance)) return;
                        if (!out.try_push_back({static_cast<std::int16_t>(i), std::atan2(n.y(), n.x()), error}))
                          ++cuts.neighbours;
                      });
}

double wrap(double angle_rad, double period_rad) noexcept {
  return angle_rad - period_rad * std::round(angle_rad / period_rad);
}

/// Numbers the neighbours by eight-fold symmetry, the first fitting phase that most agree with. \return dots numbered
int number_neighbours(const NeighbourList& neighbours, Hypothesis& hypothesis) noexcept {
  int best = 0;
  for (const Neighbour& reference : neighbours) {
    std::array<std::int16_t, kDotCount> blob;
    blob.fill(-1);
    std::array<float, kRingDotCount> cost{};
    int count = 0;
    for (const Neighbour& n : neighbours) {
      const double turn_rad = n.angle_rad - reference.angle_rad;
      const double off_rad = wrap(turn_rad, kSlot_rad);
      if (std::abs(off_rad) > kSlotTolerance_rad) continue;
      const auto slot =
          static_cast<std::size_t>((static_cast<int>(std::lround((turn_rad - off_rad) / kSlot_rad)) + 16) % 8);
      const float c = std::abs(n.radius_error) + std::abs(static_cast<float>(off_rad));
      if (blob[slot] >= 0 && cost[slot] <= c) continue;
      if (blob[slot] < 0) ++count;
      blob[slot] = n.blob;
      cost[slot] = c;
    }
    if (count > best) best = count, hypothesis.blob = blob;
  }
  return best;
}

std::size_t collect_matches(const BlobList& blobs, const LandmarkGeometry& landmark, const Hypothesis& hypothesis,
                            std::array<PlanePoint, kDotCount>& matches) noexcept {
  std::size_t count = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (hypothesis.blob[dot] < 0) continue;
    const Blob& blob = blobs[static_cast<std::size_t>(hypothesis.blob[dot])];
    matches[count++] = {landmark.centre_m(dot), Eigen::Vector2d(blob.x_px, blob.y_px)};
  }
  return count;
}

bool fit(const BlobList& blobs, const LandmarkGeometry& landmark, Hypothesis& hypothesis) noexcept {
  std::array<PlanePoint, kDotCount> matches;
  const std::size_t count = collect_matches(blobs, landmark, hypothesis, matches);
  return count >= 3 && fit_plane_map(std::span(matches).first(count), hypothesis.H_px_plane);
}

/// Three neighbours on the ring of a guess that is there already lead to it again.
bool is_known_triple(const HypothesisList& list, std::int16_t before, std::int16_t middle,
                     std::int16_t after) noexcept {
  return std::any_of(list.begin(), list.end(), [&](const Hypothesis& known) {
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot)
      if (known.blob[dot] == middle) return known.blob[(dot + 7) % 8] == before && known.blob[(dot + 1) % 8] == after;
    return false;
  });
}

/// Guesses that found the same dots say the same.
bool is_known(const HypothesisList& list, const Hypothesis& candidate) noexcept {
  return std::any_of(list.begin(), list.end(), [&](const Hypothesis& known) {
    int common = 0;
    for (const std::int16_t blob : candidate.blob)
      if (blob >= 0 && std::find(known.blob.begin(), known.blob.end(), blob) != known.blob.end()) ++common;
    return common == candidate.matched && known.matched >= candidate.matched;
  });
}

void keep(const SortedBlobs& blobs, const LandmarkGeometry& landmark, int min_matched, Hypothesis& hypothesis,
          HypothesisList& out, GuessCuts& cuts) noexcept {
  if (!attach_blobs(blobs, landmark, hypothesis) || hypothesis.matched < min_matched || is_known(out, hypothesis))
    return;
  if (out.try_push_back(hypothesis)) return;
  ++cuts.hypotheses;  // one of them goes: the list is full
  Hypothesis* worst =
      std::min_element(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.matched < b.matched; });
  if (worst->matched < hypothesis.matched) *worst = hypothesis;
}

}  // namespace

void SortedBlobs::assign(BlobList& blobs) noexcept {
  std::sort(blobs.begin(), blobs.end(), [](const Blob& a, const Blob& b) { return a.area_px2 > b.area_px2; });
  blobs_ = &blobs;
  grid_.build(blobs.span());
}

std::size_t SortedBlobs::count_from(float area_px2) const noexcept {
  const auto* end = std::partition_point(blobs_->begin(), blobs_->end(),
                                         [area_px2](const Blob& blob) { return blob.area_px2 >= area_px2; });
  return static_cast<std::size_t>(end - blobs_->begin());
}

bool attach_blobs(const SortedBlobs& blobs, const LandmarkGeometry& landmark, Hypothesis& hypothesis) noexcept {
  // Generous while H rests on a guess; then what a fit to all dots leaves: a fifth of the radius, half a pixel for
  // small ones.
  struct Tolerance {
    double reach, reach_px, area_factor;
  };
  constexpr std::array<Tolerance, 3> kRounds{{{0.5, 0, 1.5}, {0.3, 0.5, 1.4}, {0.2, 0.5, 1.3}}};
  for (const Tolerance& tolerance : kRounds) {
    hypothesis.matched = 0;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      hypothesis.blob[dot] = -1;
      const Eigen::Vector2d at_px = map_point(hypothesis.H_px_plane, landmark.centre_m(dot));
      const Eigen::Matrix2d J = jacobian_of_map(hypothesis.H_px_plane, landmark.centre_m(dot));
      const double det = J.determinant();
      if (!(det > 0)) return false;  // seen from behind, or across the horizon
      const Eigen::Matrix2d J_inverse = J.inverse();
      const double radius_m = landmark.radius_m(dot);
      const double area_px2 = kPi * radius_m * radius_m * det;
      // Half a pixel of blur or threshold moves a small outline by much of its size.
      const double slack = tolerance.area_factor + 3 / std::sqrt(area_px2);
      double nearest = tolerance.reach + tolerance.reach_px / std::sqrt(area_px2 / kPi);
      const double reach_px = nearest * radius_m * J.norm();
      const Eigen::Matrix2d shape_px2 = J * J.transpose() * (radius_m * radius_m / 4);
      blobs.for_each_near(static_cast<float>(at_px.x()), static_cast<float>(at_px.y()), static_cast<float>(reach_px),
                          area_px2 / slack, area_px2 * slack, [&](std::size_t i, const Blob& blob) {
                            const Eigen::Vector2d off_px(blob.x_px - at_px.x(), blob.y_px - at_px.y());
                            const double distance = (J_inverse * off_px).norm() / radius_m;
                            if (distance < nearest && shape_mismatch(blob, shape_px2) < slack)
                              nearest = distance, hypothesis.blob[dot] = static_cast<std::int16_t>(i);
                          });
      if (hypothesis.blob[dot] >= 0) ++hypothesis.matched;
    }
    if (!fit(blobs.list(), landmark, hypothesis)) return false;
  }
  return true;
}

bool guess_from_centre(const SortedBlobs& blobs, const LandmarkGeometry& landmark, int& allowance,
                       std::size_t& begin_at, HypothesisList& out, GuessCuts& cuts) noexcept {
  constexpr float kMinArea_px2 = 8;  // P9 at 9 m and 720 px, 52 degrees aside: pi / 4 (50.8 mm 720 px / 9 m)^2 cos 52
  const std::size_t count = blobs.count_from(kMinArea_px2);
  NeighbourList neighbours;
  const std::size_t done = go_round(count, begin_at, [&](std::size_t centre) {
    find_ring_around(blobs, centre, landmark, neighbours, cuts);
    if (neighbours.size() < 3) return true;
    Hypothesis hypothesis;
    if (number_neighbours(neighbours, hypothesis) < 3) return true;
    if (!take_one(allowance)) return false;
    hypothesis.blob[kCentreDot] = static_cast<std::int16_t>(centre);
    if (fit(blobs.list(), landmark, hypothesis)) keep(blobs, landmark, 4, hypothesis, out, cuts);
    return true;
  });
  cuts.hypotheses += static_cast<std::uint32_t>(count - done);
  return done == count;
}

namespace {

// Ratio of neighbours' areas, of one dot's and what three points say of it, and of its shape; and the distance to a
// neighbour in units of the ring's spacing, seen through a dot's own ellipse. DetectorConstants (see above) has what
// perspective makes of them.
constexpr double kAreaFactor = 1.7;
constexpr float kNearestSpacing = 0.6F, kFarthestSpacing = 1.5F;
constexpr std::size_t kNearest = 8;  // both neighbours on the ring, and three times as many others

struct Near {
  std::int16_t blob;
  float distance;  // from the ring's spacing, in units of it
};
using NearList = InlineVector<Near, kNearest>;

void find_neighbours_of(const SortedBlobs& blobs, std::size_t middle, const LandmarkGeometry& landmark, NearList& near,
                        GuessCuts& cuts) noexcept {
  const Blob& m = blobs.list()[middle];
  const Whitening whiten(m);
  const auto spacing = static_cast<float>(2 * std::sin(kSlot_rad / 2) * landmark.ring_radius_m / landmark.dot_radius_m);
  const float reach_px = m.semi_major_px() * kFarthestSpacing * spacing;
  near.clear();
  blobs.for_each_near(m.x_px, m.y_px, reach_px, m.area_px2 / kAreaFactor, m.area_px2 * kAreaFactor,
                      [&](std::size_t i, const Blob& blob) {
                        const float distance = whiten(blob.x_px, blob.y_px).norm() / spacing;
                        if (i == middle || distance < kNearestSpacing || distance > kFarthestSpacing) return;
                        const Near candidate{static_cast<std::int16_t>(i), std::abs(distance - 1)};
                        if (near.try_push_back(candidate)) return;
                        ++cuts.neighbours;
                        Near* worst = std::max_element(near.begin(), near.end(), [](const Near& a, const Near& b) {
                          return a.distance < b.distance;
                        });
                        if (candidate.distance < worst->distance) *worst = candidate;
                      });
}

}  // namespace

bool guess_from_ring(const SortedBlobs& blobs, const LandmarkGeometry& landmark, int& allowance, std::size_t& begin_at,
                     HypothesisList& out, GuessCuts& cuts) noexcept {
  constexpr float kMinArea_px2 = 5;  // a ring dot at 7.2 m and 720 px, from in front: pi / 4 (25.4 mm 720 px / 7.2 m)^2
  Eigen::Matrix2d plane;
  plane << landmark.centre_m(7) - landmark.centre_m(0), landmark.centre_m(1) - landmark.centre_m(0);
  const Eigen::Matrix2d plane_inverse = plane.inverse();
  const double radius2_m2 = landmark.dot_radius_m * landmark.dot_radius_m;
  const BlobList& list = blobs.list();
  const std::size_t count = blobs.count_from(kMinArea_px2);
  NearList near;
  const std::size_t done = go_round(count, begin_at, [&](std::size_t middle) {
    find_neighbours_of(blobs, middle, landmark, near, cuts);
    const Blob& m = list[middle];
    for (const Near& before : near) {
      for (const Near& after : near) {
        if (before.blob == after.blob) continue;
        const Blob& a = list[static_cast<std::size_t>(before.blob)];
        const Blob& c = list[static_cast<std::size_t>(after.blob)];
        Eigen::Matrix2d seen;
        seen << a.x_px - m.x_px, c.x_px - m.x_px, a.y_px - m.y_px, c.y_px - m.y_px;
        const Eigen::Matrix2d J = seen * plane_inverse;
        const double area_px2 = kPi * radius2_m2 * J.determinant();
        if (!(area_px2 > m.area_px2 / kAreaFactor && area_px2 < m.area_px2 * kAreaFactor)) continue;
        if (shape_mismatch(m, J * J.transpose() * (radius2_m2 / 4)) > kAreaFactor) continue;
        if (is_known_triple(out, before.blob, static_cast<std::int16_t>(middle), after.blob)) continue;
        if (!take_one(allowance)) return false;
        Hypothesis hypothesis;
        hypothesis.H_px_plane.setIdentity();
        hypothesis.H_px_plane.topLeftCorner<2, 2>() = J;
        hypothesis.H_px_plane.topRightCorner<2, 1>() = Eigen::Vector2d(m.x_px, m.y_px) - J * landmark.centre_m(0);
        // Three whole dots are all that half a sheet may leave; P9's visible part then decides.
        keep(blobs, landmark, 3, hypothesis, out, cuts);
      }
    }
    return true;
  });
  cuts.hypotheses += static_cast<std::uint32_t>(count - done);
  return done == count;
}

}  // namespace ninedot
