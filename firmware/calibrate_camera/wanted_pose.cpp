// Poses are tried, not solved for: each is held to the same count that real views are held to, so what the ghost
// promises is what its match is taken for.
#include "calibrate_camera/wanted_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace ninedot {
namespace {

/// Of the picture's height. Those of a third and more are near; the smaller one leaves room for a tilt in a corner.
constexpr std::array<double, 4> kHeights{0.42, 0.5, 0.34, 0.27};
/// Half way from where a view counts as tilted, 25 degrees, to where dots begin to be narrow: a hand's ten degrees
/// beside it are tilted still.
constexpr double kTilt_rad = 36 * std::numbers::pi / 180;
/// Towards where a sheet is furthest, in the order of kTiltNames; first none.
const std::array<Eigen::Vector2d, 1 + kTiltNames.size()> kAway{
    {Eigen::Vector2d{0, 0}, {1, 0}, {-1, 0}, {0, -1}, {0, 1}}};
/// Between the line of sight to any disc and the sheet's normal: beyond it dots are narrow and the search has trouble.
const double kLeastFacing = std::cos(52 * std::numbers::pi / 180);
/// Off the lens's axis. What a fisheye shows further out is squeezed so much that few outlines can be measured.
const double kLeastAhead = std::cos(66 * std::numbers::pi / 180);
/// From the picture's border, in widths of it: as near as can be, else where such a lens shows enough.
constexpr std::array<double, 2> kInsets{0, 0.07};
/// Ink needs paper around it that is in the picture too: as many radii from the middle of a disc.
constexpr double kRoom_radii = 1.6;
/// What the discs' middles are off by from any homography, in widths of the picture: 4.8 px of 640. Search and outlines
/// begin with one, and a sheet that the lens bends by 6 px was not seen whole.
constexpr double kMostBent_widths = 0.0075;
/// Further away than this from all views that there are one is as new as any: a twelfth of the picture's width.
constexpr double kFar_widths = 1.0 / 12;
/// A view counts for a part with one dot in it; a hand that is off by a dot's distance must not lose it.
constexpr int kDiscsInPart = 2;
constexpr int kPlacements = 5;  // each is off by a tenth of what the one before was
constexpr int kOutlinePoints = 12, kSidePoints = 6;

struct Attempt {
  std::size_t part = 0;    // of the picture, in whose outermost corner the sheet is to be
  double inset = 0;        // of kInsets
  double height = 0;       // of kHeights
  Eigen::Vector2d away;    // of kAway
  bool is_facing = false;  // the lens, not along its axis: what a fisheye needs at its border
};

class PoseMaker {
 public:
  PoseMaker(const CameraModel& lens, std::span<const PlaneDisc> discs) : lens_(lens), discs_(discs) {
    for (const PlaneDisc& disc : discs) middle_m_ += disc.centre_m / static_cast<double>(discs.size());
    for (const PlaneDisc& disc : discs) radius_m_ = std::max(radius_m_, (disc.centre_m - middle_m_).norm());
  }

  /// \return  nothing: the sheet would not be whole in the picture
  std::optional<CameraFromLandmark> pose_of(const Attempt& attempt) const {
    Eigen::Vector2d at_px = middle_of_part(attempt.part);
    CameraFromLandmark T;
    for (int i = 0; i < kPlacements; ++i) {
      const auto ray = lens_.normalised_from_pixel(at_px);
      if (!ray) return std::nullopt;
      T = held_along(ray->homogeneous(), attempt);
      Eigen::AlignedBox2d box;
      for (const PlaneDisc& disc : discs_)
        if (!extend(box, T, disc)) return std::nullopt;
      at_px += shift_of(box, attempt);
      if (!(at_px.array() >= 0).all() || at_px.x() > lens_.width_px - 1 || at_px.y() > lens_.height_px - 1)
        return std::nullopt;
    }
    return is_whole(T) ? std::optional(T) : std::nullopt;
  }

  /// As a search would give it.
  SheetView view_of(const CameraFromLandmark& T) const {
    SheetView view;
    for (std::size_t disc = 0; disc < discs_.size(); ++disc)
      view.seen.push_back(
          {disc, lens_.pixel_from_normalised(project_disc_centre(T, discs_[disc].centre_m, discs_[disc].radius_m))});
    return view;
  }

 private:
  Eigen::Vector2d middle_of_part(std::size_t part) const {
    const std::size_t column = part % 3, row = part / 3;
    return {(0.5 + static_cast<double>(column)) * lens_.width_px / 3,
            (0.5 + static_cast<double>(row)) * lens_.height_px / 3};
  }

  CameraFromLandmark held_along(const Eigen::Vector3d& ray, const Attempt& attempt) const {
    // Seen from the front X0 is to the left, Z0 upwards and Y0 towards the camera.
    Eigen::Matrix3d rotation;
    rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;
    const Eigen::Vector3d away(attempt.away.x(), attempt.away.y(), 0);
    if (!away.isZero()) rotation = Eigen::AngleAxisd(kTilt_rad, away.cross(Eigen::Vector3d::UnitZ())) * rotation;
    if (attempt.is_facing)
      rotation = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray).toRotationMatrix() * rotation;
    const double distance_m = 2 * radius_m_ * lens_.fy_px / (attempt.height * lens_.height_px);
    const Eigen::Vector3d middle = distance_m * (attempt.is_facing ? ray.normalized().eval() : ray);
    return {rotation, middle - rotation * Eigen::Vector3d(middle_m_.x(), 0, middle_m_.y())};
  }

  bool extend(Eigen::AlignedBox2d& box, const CameraFromLandmark& T, const PlaneDisc& disc) const {
    const SheetMap map = map_of_camera(lens_, T);
    for (int i = 0; i < kOutlinePoints; ++i) {
      const double angle = 2 * std::numbers::pi * i / kOutlinePoints;
      const Eigen::Vector2d at_m =
          disc.centre_m + kRoom_radii * disc.radius_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      if ((T * Eigen::Vector3d(at_m.x(), 0, at_m.y())).z() <= disc.radius_m) return false;
      box.extend(map(at_m));
    }
    return true;
  }

  /// To the picture's border where the part has one, to its middle where it has none.
  Eigen::Vector2d shift_of(const Eigen::AlignedBox2d& box, const Attempt& attempt) const {
    const double inset_px = attempt.inset * lens_.width_px;
    const auto along = [&](std::size_t third, double low, double high, double end) {
      return third == 0 ? inset_px - low : third == 2 ? end - inset_px - high : 0.5 * (end - low - high);
    };
    return {along(attempt.part % 3, box.min().x(), box.max().x(), lens_.width_px - 1.0),
            along(attempt.part / 3, box.min().y(), box.max().y(), lens_.height_px - 1.0)};
  }

  /// Also where the lens's formulas turn back beyond its field, and show there what is elsewhere.
  bool is_whole(const CameraFromLandmark& T) const {
    const Eigen::AlignedBox2d picture(Eigen::Vector2d(-2, -2),
                                      Eigen::Vector2d(lens_.width_px + 1.0, lens_.height_px + 1.0));
    for (const PlaneDisc& disc : discs_) {
      Eigen::AlignedBox2d box;
      if (!extend(box, T, disc) || !picture.contains(box)) return false;
      const Eigen::Vector3d middle = T * Eigen::Vector3d(disc.centre_m.x(), 0, disc.centre_m.y());
      const Eigen::Vector3d towards = middle.normalized();
      if (towards.z() < kLeastAhead || -towards.dot(T.rotation.col(1)) < kLeastFacing) return false;
      const Eigen::Vector2d point = project_plane_point(T, disc.centre_m);
      const auto back = lens_.normalised_from_pixel(lens_.pixel_from_normalised(point));
      if (!back || (*back - point).norm() > 1e-3 * (1 + point.norm())) return false;
    }
    return true;
  }

  const CameraModel& lens_;
  std::span<const PlaneDisc> discs_;
  Eigen::Vector2d middle_m_{0, 0};
  double radius_m_ = 0;
};

bool is_bent(const SheetView& view, std::span<const PlaneDisc> discs, int width_px) {
  Eigen::Matrix3d H;
  return !fit_sheet_map(view.seen, discs, H) || std::ranges::any_of(view.seen, [&](const SeenDisc& disc) {
    return (map_point(H, discs[disc.disc].centre_m) - disc.centre_px).norm() > kMostBent_widths * width_px;
  });
}

bool meets(const Want& want, const SheetView& view, const ViewTally& tally, const CameraModel& lens) {
  if (want.kind != Want::Kind::kPart) return is_wanted(want, tally);
  return std::ranges::count_if(view.seen, [&](const SeenDisc& disc) {
           return part_of(disc.centre_px, lens.width_px, lens.height_px) == want.which;
         }) >= kDiscsInPart;
}

double distance_to_nearest_px(const SheetView& view, const ViewCollection& views) {
  double nearest_px = std::numeric_limits<double>::infinity();
  for (const SheetView& other : views.views()) nearest_px = std::min(nearest_px, distance_px(view, other));
  return nearest_px;
}

/// Where to look first: the wanted part, or all of them.
std::vector<std::size_t> parts_for(const Want& want) {
  if (want.kind == Want::Kind::kPart) return {want.which};
  return {4, 0, 1, 2, 3, 5, 6, 7, 8};
}

}  // namespace

std::optional<WantedPose> pose_for(std::span<const Want> wanted, const CameraModel& lens,
                                   std::span<const PlaneDisc> discs, const ViewCollection& views) {
  if (wanted.empty()) return std::nullopt;
  const PoseMaker maker(lens, discs);
  std::optional<WantedPose> best;
  double best_px = 0;
  const auto consider = [&](const Attempt& attempt) {
    const std::optional<CameraFromLandmark> T = maker.pose_of(attempt);
    if (!T) return;
    const SheetView view = maker.view_of(*T);
    if (is_bent(view, discs, lens.width_px)) return;
    const ViewTally tally = tally_of(std::span(&view, 1), discs, lens.width_px, lens.height_px);
    WantedPose pose{*T, {}};
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (meets(wanted[i], view, tally, lens)) pose.meets.push_back(i);
    if (pose.meets.empty() || pose.meets.front() != 0 || !views.is_new(view)) return;
    const double px = std::min(distance_to_nearest_px(view, views), kFar_widths * lens.width_px);
    const std::size_t most = best ? best->meets.size() : 0;
    if (pose.meets.size() < most || (pose.meets.size() == most && px <= best_px)) return;
    best = std::move(pose), best_px = px;
  };
  for (const std::size_t part : parts_for(wanted.front()))
    for (const double inset : kInsets)
      for (const bool is_facing : {false, true})
        for (const Eigen::Vector2d& away : kAway)
          for (const double height : kHeights) consider({part, inset, height, away, is_facing});
  return best;
}

std::vector<std::vector<Eigen::Vector2d>> outlines_of(const SheetMap& map, std::span<const PlaneDisc> discs) {
  Eigen::AlignedBox2d sheet;
  double margin_m = 0;
  for (const PlaneDisc& disc : discs) {
    margin_m = std::max(margin_m, disc.radius_m);
    const Eigen::Vector2d radius = Eigen::Vector2d::Constant(disc.radius_m);
    sheet.extend(disc.centre_m + radius).extend(disc.centre_m - radius);
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(margin_m / 2);
  const Eigen::Vector2d low = sheet.min() - margin, high = sheet.max() + margin;
  const std::array<Eigen::Vector2d, 4> corners{{low, {high.x(), low.y()}, high, {low.x(), high.y()}}};
  std::vector<std::vector<Eigen::Vector2d>> outlines(1);
  for (std::size_t side = 0; side < corners.size(); ++side)
    for (int i = 0; i < kSidePoints; ++i) {
      const Eigen::Vector2d along = corners[(side + 1) % corners.size()] - corners[side];
      outlines.front().push_back(map(corners[side] + along * i / kSidePoints));
    }
  if (discs.size() > kMostOutlined) return outlines;
  for (const PlaneDisc& disc : discs) {
    std::vector<Eigen::Vector2d>& outline = outlines.emplace_back();
    for (int i = 0; i < kOutlinePoints; ++i) {
      const double angle = 2 * std::numbers::pi * i / kOutlinePoints;
      outline.push_back(map(disc.centre_m + disc.radius_m * Eigen::Vector2d(std::cos(angle), std::sin(angle))));
    }
  }
  return outlines;
}

}  // namespace ninedot
