#include "detect/detector.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/contract.h"
#include "detect/blob_finder.h"
#include "detect/homography.h"
#include "detect/hypothesis.h"
#include "detect/verify.h"
#include "geometry/planar_pose.h"

// picture -> blobs -> hypotheses -> the one that the grey levels confirm best -> numbered dots.
// The founding paper votes for ellipses in a Hough space; blobs by a local threshold need no votes, no parameter of
// size, and a hundredth of the time, and a shadow's edge across the sheet leaves them whole (measured: docs/method.md).

namespace ninedot {
namespace {

/// Blobs know nothing of the landmark: what is hidden, spoiled or at the picture's edge is told by the outlines.
constexpr float kWholeOutline = 0.9F;

struct Window {
  int x = 0, y = 0, width = 0, height = 0;
};

ImageView cut(const ImageView& luma, const Window& w) noexcept {
  return {luma.row(w.y) + w.x, w.width, w.height, luma.stride_bytes};
}

}  // namespace

struct Detector::Workspace {
  Workspace(const CameraModel& camera_model, const LandmarkGeometry& landmark_geometry,
            const DetectorOptions& detector_options)
      : camera(camera_model),
        landmark(landmark_geometry),
        options(detector_options),
        finder(camera_model.width_px, camera_model.height_px),
        sorted(camera_model.width_px, camera_model.height_px) {}

  Result<LandmarkObservation> find(const ImageView& luma, const Window& searched, BlobFinder::Levels wanted) noexcept;
  Result<LandmarkObservation> match(const ImageView& luma) noexcept;
  Verification verify(const ImageView& luma, const Hypothesis& hypothesis) const noexcept;
  bool best_hypothesis(const ImageView& luma, Verification& verification) noexcept;
  Result<LandmarkObservation> observe(const Verification& verification) noexcept;
  bool is_cut(std::size_t dot, const Blob& blob) const noexcept;
  void number_dots(std::span<const PlanePoint> points, LandmarkObservation& seen) const noexcept;

  CameraModel camera;
  LandmarkGeometry landmark;
  DetectorOptions options;
  BlobFinder finder;
  BlobList blobs;
  SortedBlobs sorted;
  HypothesisList hypotheses;
  Hypothesis best;
  Window window;  ///< of the search under way
  BlobFinder::Levels levels;
};

Result<LandmarkObservation> Detector::Workspace::find(const ImageView& luma, const Window& searched,
                                                      BlobFinder::Levels wanted) noexcept {
  window = searched;
  levels = wanted;
  finder.find_blobs(cut(luma, window), levels, blobs);
  for (Blob& blob : blobs) {
    blob.x_px += static_cast<float>(window.x);
    blob.y_px += static_cast<float>(window.y);
  }
  return match(luma);
}

/// The landmark among the blobs at hand.
Result<LandmarkObservation> Detector::Workspace::match(const ImageView& luma) noexcept {
  sorted.assign(blobs);
  Verification verification;
  hypotheses.clear();
  guess_from_centre(sorted, landmark, hypotheses);
  if (!best_hypothesis(luma, verification)) {
    hypotheses.clear();
    guess_from_ring(sorted, landmark, hypotheses);
    if (!best_hypothesis(luma, verification)) return fail(Errc::kNoLandmark, "no landmark in the picture");
  }
  return observe(verification);
}

/// Small dots are looked at in the picture itself, larger ones at a level of the pyramid where noise is averaged away.
Verification Detector::Workspace::verify(const ImageView& luma, const Hypothesis& hypothesis) const noexcept {
  constexpr double kSmallest_px = 2.5;  // semi-minor axis of a ring dot in the picture that is looked at
  const Eigen::Matrix2d J = jacobian_of_map(hypothesis.H_px_plane, Eigen::Vector2d::Zero());
  const double semi_minor_px = landmark.dot_radius_m * std::abs(J.determinant()) / std::max(J.norm(), 1e-9);
  int level = 0;
  while (level <= levels.last && semi_minor_px > kSmallest_px * (2 << level)) ++level;
  if (level == 0) return verify_landmark(luma, hypothesis.H_px_plane, landmark, blobs, hypothesis, finder.noise_lsb());
  const double scale = 1.0 / (1 << level);
  Eigen::Matrix3d to_level = Eigen::Matrix3d::Identity();
  to_level(0, 0) = to_level(1, 1) = scale;
  to_level(0, 2) = (0.5 - window.x) * scale - 0.5;
  to_level(1, 2) = (0.5 - window.y) * scale - 0.5;
  return verify_landmark(finder.picture_at(level), to_level * hypothesis.H_px_plane, landmark, blobs, hypothesis,
                         finder.noise_lsb() * scale);
}

bool Detector::Workspace::best_hypothesis(const ImageView& luma, Verification& verification) noexcept {
  bool any = false;
  for (const Hypothesis& hypothesis : hypotheses) {
    const Verification v = verify(luma, hypothesis);
    if (!v.accepted || (any && v.score <= verification.score)) continue;
    any = true;
    verification = v;
    best = hypothesis;
  }
  return any;
}

/// A dot that something hides in part has an outline all around all the same, but it is smaller than the others say.
bool Detector::Workspace::is_cut(std::size_t dot, const Blob& blob) const noexcept {
  const double radius_m = landmark.radius_m(dot);
  const double whole_px2 =
      std::numbers::pi * radius_m * radius_m * jacobian_of_map(best.H_px_plane, landmark.centre_m(dot)).determinant();
  // A seventh (a shadow across a dot costs a tenth), and a threshold that is off by a sixth of a pixel all around.
  return static_cast<double>(blob.area_px2) < whole_px2 * (0.85 - 1.2 / std::sqrt(whole_px2));
}

Result<LandmarkObservation> Detector::Workspace::observe(const Verification& verification) noexcept {
  LandmarkObservation seen;
  std::array<PlanePoint, kDotCount> matches;
  InlineVector<PlanePoint, kDotCount> points;
  std::size_t count = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    DotObservation& d = seen.dots[dot];
    d.visible_fraction = verification.visible_fraction[dot];
    if (best.blob[dot] < 0) continue;
    const Blob& blob = blobs[static_cast<std::size_t>(best.blob[dot])];
    d.seen = d.visible_fraction >= kWholeOutline && !is_cut(dot, blob);
    d.centroid_px = {blob.x_px, blob.y_px};
    const double mean = 0.5 * (static_cast<double>(blob.xx_px2) + blob.yy_px2);
    const double half = 0.5 * (static_cast<double>(blob.xx_px2) - blob.yy_px2);
    const double spread = std::hypot(half, static_cast<double>(blob.xy_px2));
    d.semi_major_px = 2 * std::sqrt(mean + spread);
    d.semi_minor_px = 2 * std::sqrt(std::max(mean - spread, 0.0));
    d.angle_rad = 0.5 * std::atan2(2.0 * static_cast<double>(blob.xy_px2), 2 * half);
    seen.seen_count += d.seen;
    const auto ray = camera.normalised_from_pixel(d.centroid_px);
    if (!ray) return tl::unexpected<Error>(ray.error());
    matches[count++] = {landmark.centre_m(dot), *ray};
    (void)points.try_push_back({landmark.centre_m(dot), *ray});
  }
  if (!fit_plane_map(std::span(matches).first(count), seen.H_ray_plane))
    return fail(Errc::kPoseDegenerate, "the visible dots lie on a line");
  number_dots(points.span(), seen);
  return seen;
}

/// The ring looks the same after an eighth of a turn: eight numberings, each of which makes another camera. A camera
/// stands upright (but for the expected roll) and not far above or below the landmark, so P1 is the dot that needs the
/// least roll and elevation together: seen from in front the lowest dot. From diagonally above the lowest dot may be a
/// neighbour, and roll tells them apart; from 75 degrees aside neighbours differ by 15 degrees of roll, but by 40 of
/// elevation.
void Detector::Workspace::number_dots(std::span<const PlanePoint> points, LandmarkObservation& seen) const noexcept {
  constexpr double kRollSigma_rad = 14 * std::numbers::pi / 180;       // hand-levelled mounts, uneven floors
  constexpr double kElevationSigma_rad = 50 * std::numbers::pi / 180;  // weak: cameras hang under ceilings too
  // The rigid pose, because a distant landmark's homography has eight unknowns of which two are noise.
  Eigen::Vector3d X = seen.H_ray_plane.col(0).normalized();
  Eigen::Vector3d Z = seen.H_ray_plane.col(1).normalized();
  Eigen::Vector3d to_camera = -seen.H_ray_plane.col(2).normalized();
  if (const auto poses = solve_planar_pose(points)) {
    X = poses->front().T_camera_landmark.rotation.col(0);
    Z = poses->front().T_camera_landmark.rotation.col(2);
    to_camera = -poses->front().T_camera_landmark.translation_m.normalized();
  }
  std::size_t lowest = 0;
  double least = 1e9;
  for (std::size_t k = 0; k < kRingDotCount; ++k) {
    const Eigen::Vector2d towards = landmark.centre_m(k).normalized();
    const Eigen::Vector3d up = -(towards.x() * X + towards.y() * Z);
    const double roll_rad =
        std::remainder(std::atan2(up.x(), -up.y()) - options.expected_roll_rad, 2 * std::numbers::pi);
    const double elevation_rad = std::asin(std::clamp(up.dot(to_camera), -1.0, 1.0));
    const double cost = std::pow(roll_rad / kRollSigma_rad, 2) + std::pow(elevation_rad / kElevationSigma_rad, 2);
    if (cost < least) least = cost, lowest = k;
  }
  if (lowest == 0) return;
  const auto dots = seen.dots;
  for (std::size_t k = 0; k < kRingDotCount; ++k) seen.dots[k] = dots[(k + lowest) % kRingDotCount];
  // New coordinates X' of the same point: old = turn * new, where turn carries P1 to where dot `lowest` was.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() =
      Eigen::Rotation2Dd(static_cast<double>(lowest) * std::numbers::pi / 4).toRotationMatrix();
  seen.H_ray_plane = seen.H_ray_plane * turn;
}

Detector::Detector(const CameraModel& camera, const LandmarkGeometry& landmark, const DetectorOptions& options)
    : workspace_(std::make_unique<Workspace>(camera, landmark, options)) {}

Detector::~Detector() = default;

Result<LandmarkObservation> Detector::find_landmark(const ImageView& luma) noexcept {
  const CameraModel& camera = workspace_->camera;
  if (luma.width_px != camera.width_px || luma.height_px != camera.height_px)
    return fail(Errc::kFrameSize, "the frame's size is not the calibration's");
  // Three quarters of all pixels are the picture's own. A landmark nearer than about 4 m shows at half the size as
  // well, and is then measured where it is.
  Workspace& w = *workspace_;
  const Window whole{0, 0, luma.width_px, luma.height_px};
  if (const auto coarse = w.find(luma, whole, {1, BlobFinder::kLevels - 1})) {
    if (auto fine = find_landmark_near(luma, *coarse)) return fine;
    return w.find(luma, whole, {});
  }
  w.finder.add_finer_level(luma, w.blobs);
  w.levels.first = 0;
  return w.match(luma);
}

Result<LandmarkObservation> Detector::find_landmark_near(const ImageView& luma,
                                                         const LandmarkObservation& predicted) noexcept {
  const CameraModel& camera = workspace_->camera;
  const LandmarkGeometry& landmark = workspace_->landmark;
  if (luma.width_px != camera.width_px || luma.height_px != camera.height_px)
    return fail(Errc::kFrameSize, "the frame's size is not the calibration's");

  // The box around all outlines, and half as much again on every side: a landmark may move by that between two frames.
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  const double reach_m = landmark.ring_radius_m + landmark.dot_radius_m;
  for (int i = 0; i < 16; ++i) {
    const double a_rad = i * std::numbers::pi / 8;
    const Eigen::Vector2d ray =
        map_point(predicted.H_ray_plane, reach_m * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad)));
    const Eigen::Vector2d px = camera.pixel_from_normalised(ray);
    low = low.cwiseMin(px), high = high.cwiseMax(px);
  }
  constexpr double kMargin = 0.3;  // of the box, on every side
  constexpr double kLeastMargin_px = 12;
  const Eigen::Vector2d margin = (kMargin * (high - low)).cwiseMax(kLeastMargin_px);
  const auto clamp_x = [&](double x) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(luma.width_px)));
  };
  const auto clamp_y = [&](double y) {
    return static_cast<int>(std::clamp(y, 0.0, static_cast<double>(luma.height_px)));
  };
  const int x0 = clamp_x(low.x() - margin.x()), x1 = clamp_x(high.x() + margin.x() + 1);
  const int y0 = clamp_y(low.y() - margin.y()), y1 = clamp_y(high.y() + margin.y() + 1);
  if (x1 - x0 < 16 || y1 - y0 < 16) return fail(Errc::kNoLandmark, "the landmark has left the picture");

  // The levels that see the ring's dots (narrower way) and P9 (wider way) at 2 to 20 of their pixels.
  double narrow_px = 1e9, wide_px = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Matrix2d J = jacobian_of_map(predicted.H_ray_plane, landmark.centre_m(dot));
    const double size_px = 2 * landmark.radius_m(dot) * camera.fx_px;
    const double product = std::abs(J.determinant());
    const double largest = J.norm();
    narrow_px = std::min(narrow_px, size_px * product / std::max(largest, 1e-12));
    wide_px = std::max(wide_px, size_px * largest);
  }
  BlobFinder::Levels levels{0, 0};
  while (levels.first < BlobFinder::kLevels - 1 && narrow_px > 8 * (2 << levels.first)) ++levels.first;
  levels.last = levels.first;
  while (levels.last < BlobFinder::kLevels - 1 && wide_px > 14 * (1 << levels.last)) ++levels.last;
  return workspace_->find(luma, {x0, y0, x1 - x0, y1 - y0}, levels);
}

}  // namespace ninedot
