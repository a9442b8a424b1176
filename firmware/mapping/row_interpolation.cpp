#include "mapping/row_interpolation.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "base/contract.h"
#include "base/median.h"

namespace ninedot {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
constexpr std::size_t kLongest = 3;  // pictures that a polynomial goes through

/// The landmark's own place in one picture, as its rows saw it.
struct Point {
  RowedSighting* sighting;
  double time_s;        ///< of the picture's middle row, since the recording's first
  double exposed_s;     ///< of the landmark's own row, likewise
  Eigen::Vector2d ray;  ///< at that instant
  double sigma;         ///< of the ray, each axis
};
using Path = std::vector<Point>;

/// When the row that shows a ray was exposed, after the middle one. \param ray  at the middle row's instant
/// \param velocity  of it, as it was taken out
double exposed_since_s(const Eigen::Vector2d& ray, const Eigen::Vector2d& velocity, const SheetMotion& motion,
                       const CameraModel& camera) {
  double since_s = 0;
  for (int i = 0; i < 3; ++i)  // the row depends on the instant, but by a hundredth of it
    since_s = motion.since_s(camera.pixel_from_normalised(ray + since_s * velocity).y());
  return since_s;
}

Eigen::Vector2d velocity_taken_out(const RowedSighting& sighting) {
  const Eigen::Vector3d& t_m = sighting.seen->T_camera_landmark.translation_m;
  return sighting.motion.ray_velocity(t_m, t_m);
}

Point point_of(RowedSighting& sighting, MonoTime start, const CameraModel& camera) {
  const Eigen::Vector2d ray = sighting.seen->T_camera_landmark.translation_m.hnormalized();
  const Eigen::Vector2d velocity = velocity_taken_out(sighting);
  const double time_s = std::chrono::duration<double>(sighting.time - start).count();
  const double since_s = exposed_since_s(ray, velocity, sighting.motion, camera);
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (const DotSighting& dot : sighting.seen->dots) information += dot.information;
  return {&sighting, time_s, time_s + since_s, ray + since_s * velocity, std::sqrt(information.inverse().trace() / 2)};
}

/// Newton's divided difference: the highest coefficient of the polynomial through these points.
Eigen::Vector2d divided_difference(std::span<const Point> points) {
  if (points.size() == 1) return points[0].ray;
  return (divided_difference(points.subspan(1)) - divided_difference(points.first(points.size() - 1))) /
         (points.back().exposed_s - points.front().exposed_s);
}

/// Of the paths' coefficients at one power the median size. \param points  so many give one
double usual_coefficient(const std::map<std::uint16_t, Path>& paths, std::size_t points) {
  std::vector<double> sizes;
  for (const auto& [id, path] : paths)
    for (std::size_t first = 0; first + points <= path.size(); ++first)
      sizes.push_back(divided_difference(std::span(path).subspan(first, points)).norm());
  return sizes.empty() ? kUnknown : median(sizes);
}

/// A landmark's ray around the instant of its picture.
struct Motion {
  Eigen::Vector2d velocity_1_s, half_acceleration_1_s2;
  double rate_sigma_1_s;  ///< of the velocity
  Eigen::Vector2d moved(double since_s) const {
    return since_s * velocity_1_s + since_s * since_s * half_acceleration_1_s2;
  }
};

class PathInterpolation {
 public:
  /// \param usual  size of the coefficient that follows those of so many points [1/s^n]
  PathInterpolation(const Path& path, const std::array<double, kLongest + 1>& usual) : path_(path), usual_(usual) {}

  /// The most certain one of those through the picture and its neighbours.
  std::optional<Motion> motion_in(std::size_t picture) const {
    std::optional<Motion> best;
    for (std::size_t points = 2; points <= std::min(kLongest, path_.size()); ++points)
      for (std::size_t first = picture + 1 - std::min(picture + 1, points);
           first <= picture && first + points <= path_.size(); ++first) {
        const Motion motion = motion_through(first, points, picture);
        if (!best || motion.rate_sigma_1_s < best->rate_sigma_1_s) best = motion;
      }
    return best;
  }

 private:
  Motion motion_through(std::size_t first, std::size_t points, std::size_t picture) const {
    const std::span<const Point> through = std::span(path_).subspan(first, points);
    const double time_s = path_[picture].time_s;
    // Lagrange's polynomials, their derivatives at the picture's instant.
    Motion motion{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), 0};
    double variance = 0, others = 1;
    for (std::size_t i = 0; i < points; ++i) {
      double slope = 0, bend = points == 3 ? 1 : 0;
      for (std::size_t j = 0; j < points; ++j) {
        if (j == i) continue;
        double term = 1 / (through[i].exposed_s - through[j].exposed_s);
        bend *= term;
        for (std::size_t k = 0; k < points; ++k)
          if (k != i && k != j) term *= (time_s - through[k].exposed_s) / (through[i].exposed_s - through[k].exposed_s);
        slope += term;
      }
      motion.velocity_1_s += slope * through[i].ray;
      motion.half_acceleration_1_s2 += bend * through[i].ray;
      variance += slope * slope * through[i].sigma * through[i].sigma;
      if (first + i != picture) others *= std::abs(time_s - through[i].exposed_s);
    }
    motion.rate_sigma_1_s = std::hypot(std::sqrt(variance), others * next_coefficient(first, points));
    return motion;
  }

  /// What the polynomial lacks: as the neighbour tells it that disturbs less, and as it is usual; one of them may be
  /// small by chance.
  double next_coefficient(std::size_t first, std::size_t points) const {
    double own = kUnknown;
    for (std::size_t from = first - std::min<std::size_t>(first, 1); from <= first; ++from)
      if (from + points < path_.size())
        own = std::min(own, divided_difference(std::span(path_).subspan(from, points + 1)).norm());
    if (std::isinf(own)) return usual_[points];
    return std::sqrt((own * own + usual_[points] * usual_[points]) / 2);
  }

  const Path& path_;
  const std::array<double, kLongest + 1>& usual_;
};

void retake(RowedSighting& sighting, const Motion& motion, const CameraModel& camera) {
  const Eigen::Vector2d velocity = velocity_taken_out(sighting);
  const auto moved_by = [&](const Eigen::Vector2d& ray) -> Eigen::Vector2d {
    const double since_s = exposed_since_s(ray, velocity, sighting.motion, camera);
    return since_s * velocity - motion.moved(since_s);
  };
  for (DotSighting& dot : sighting.seen->dots) dot.ray += moved_by(dot.ray);
  Eigen::Vector3d& t_m = sighting.seen->T_camera_landmark.translation_m;
  t_m.head<2>() += t_m.z() * moved_by(t_m.hnormalized());
  sighting.per_row_rad = motion.rate_sigma_1_s * std::abs(sighting.motion.row_time_s);
}

}  // namespace

void interpolate_rows(std::span<RowedSighting> sightings, const CameraModel& camera) {
  std::map<std::uint16_t, Path> paths;
  for (RowedSighting& sighting : sightings) {
    EXPECTS(sighting.seen != nullptr);
    if (sighting.motion.row_time_s == 0) continue;
    const Point point = point_of(sighting, sightings.front().time, camera);
    Path& path = paths[sighting.seen->id];
    if (std::isfinite(point.sigma) && (path.empty() || point.exposed_s > path.back().exposed_s)) path.push_back(point);
  }
  std::array<double, kLongest + 1> usual{};
  for (std::size_t points = 2; points <= kLongest; ++points) usual[points] = usual_coefficient(paths, points + 1);
  for (const auto& [id, path] : paths) {
    const PathInterpolation interpolation(path, usual);
    for (std::size_t picture = 0; picture < path.size(); ++picture) {
      RowedSighting& sighting = *path[picture].sighting;
      const std::optional<Motion> motion = interpolation.motion_in(picture);
      if (motion && motion->rate_sigma_1_s * std::abs(sighting.motion.row_time_s) < sighting.per_row_rad)
        retake(sighting, *motion, camera);
    }
  }
}

}  // namespace ninedot
