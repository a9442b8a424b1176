// What a refinement that has ended says beside its pose: of other poses, of each dot, of the outlines' shapes.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "pose/outline_refiner.h"
#include "pose/outline_shape.h"

namespace ninedot {
namespace {

// Of P9's short semi-axis, and for the noise of a small one: an outline that lies further off is not P9's, whatever its
// many groups make of the scatter. A disc of one and a half times its size has half of it. (Rings of dots of other
// sizes are told by their shapes.)
constexpr double kCentreInPlace = 0.25, kInPlace_px = 0.3;
// Of a dot's radius, 1-sigma of an edge of light, the blur taken off: one through a window frame, close by, has a
// tenth, one of the sun behind a beam some metres away two thirds.
constexpr double kPenumbra = 0.2;
constexpr double kUnseenShare = 1e-3;  // of a dot's information: directions that its outline says less of

}  // namespace

double OutlineRefiner::chi2_above(const OutlineState& other, double enough) const noexcept {
  // After a short step the equations know what it has gained: all but its third order.
  const bool is_known = statistics_.stopped == Stopped::kSettled;
  double difference = is_known ? gain_ : 0;
  // What the rest of the groups can take off the difference, should the other state explain them without a residual.
  double ours_left = is_known ? 0 : std::numeric_limits<double>::infinity();
  if (is_known)
    for (std::size_t i = 0; i < pixels_.groups.size(); ++i)
      ours_left += std::max(weights_.weight[i], 0.0) * fits_[i].squared_residuals / weights_.noise_variance_lsb2;
  GroupFitter at_other(pixels_, landmark_, other, Asked::kLightOnly),
      here(pixels_, landmark_, state_, Asked::kLightOnly);
  GroupFit theirs, ours;
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    if (weights_.weight[i] <= 0) continue;
    if (difference - ours_left > enough) return difference - ours_left;
    at_other.fit(pixels_.groups[i], theirs);
    if (!is_known) here.fit(pixels_.groups[i], ours);
    const double our_squares = is_known ? fits_[i].squared_residuals : ours.squared_residuals;
    const double chi2_per_lsb2 = weights_.weight[i] / weights_.noise_variance_lsb2;
    difference += chi2_per_lsb2 * (theirs.squared_residuals - our_squares);
    ours_left -= chi2_per_lsb2 * our_squares;
  }
  return difference;
}

std::array<double, kDotCount> OutlineRefiner::visible_share() const noexcept {
  std::array<int, kDotCount> groups{}, good{};
  const double centre_px = dot_radius_px() * landmark_.centre_radius_m / landmark_.dot_radius_m;
  const double most_px = kCentreInPlace * foreshortening(state_.T_camera_landmark) * centre_px + kInPlace_px;
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    const std::size_t dot = pixels_.groups[i].dot;
    ++groups[dot];
    const bool is_in_place = dot != kCentreDot || std::abs(fits_[i].shift_px) < most_px;
    if (weights_.outline_there[i] && is_in_place) ++good[dot];
  }
  std::array<double, kDotCount> share{};
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (groups[dot] > 0) share[dot] = static_cast<double>(good[dot]) / groups[dot];
  return share;
}

/// Moving the sheet by (x, y) moves each dot's ray by that over its depth, so that what a dot says of the translation,
/// it says of its own place. The offset and the blur have moved as the step says.
DotSightings OutlineRefiner::dots() const noexcept {
  std::array<Eigen::Matrix2d, kDotCount> normal;
  std::array<Eigen::Vector2d, kDotCount> gradient;
  normal.fill(Eigen::Matrix2d::Zero());
  gradient.fill(Eigen::Vector2d::Zero());
  const Eigen::Matrix<double, 2, 3> R =
      linearised_at_.T_camera_landmark.rotation.topRows<2>();  // from the sheet's axes
  for (std::size_t i = 0; i < pixels_.groups.size(); ++i) {
    if (weights_.weight[i] <= 0) continue;
    const std::size_t dot = pixels_.groups[i].dot;
    const double weight = weights_.weight[i] / weights_.noise_variance_lsb2;
    const GroupFit& fit = fits_[i];
    normal[dot] += weight * R * fit.normal.block<3, 3>(3, 3) * R.transpose();
    gradient[dot] += weight * R *
                     (fit.gradient.segment<3>(3) - fit.normal.block<3, kUnknowns - kPoseUnknowns>(3, kPoseUnknowns) *
                                                       last_step_.tail<kUnknowns - kPoseUnknowns>());
  }
  DotSightings dots;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (!(normal[dot].trace() > 0)) continue;
    const Eigen::Vector2d C = landmark_.centre_m(dot);
    const Eigen::Vector3d p = linearised_at_.T_camera_landmark * Eigen::Vector3d(C.x(), 0, C.y());
    // Of an outline in sight on one side alone one direction is not known: it stays where it was.
    const Eigen::Matrix2d solvable = normal[dot] + kUnseenShare * normal[dot].trace() * Eigen::Matrix2d::Identity();
    dots[dot].ray = p.hnormalized() + solvable.inverse() * gradient[dot] / p.z();
    dots[dot].information = p.z() * p.z() * normal[dot];
  }
  return dots;
}

int OutlineRefiner::shadowed_dots() const noexcept {
  int shadowed = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) shadowed += cuts_[dot] != Cut::kBySize;
  return shadowed;
}

bool OutlineRefiner::has_light_edges() const noexcept {
  return std::ranges::any_of(pixels_.light_edges, [](const auto& edge) { return edge.has_value(); });
}

bool OutlineRefiner::has_penumbra() const noexcept {
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const std::optional<LightEdge>& edge = pixels_.light_edges[dot];
    if (!edge) continue;
    const double wide_px = kPenumbra * semi_minor_px(dot);
    if (edge->width_px * edge->width_px - state_.blur_px2 > wide_px * wide_px) return true;
  }
  return false;
}

double OutlineRefiner::semi_minor_px(std::size_t dot) const noexcept {
  return foreshortening(state_.T_camera_landmark) * dot_radius_px() * landmark_.radius_m(dot) / landmark_.dot_radius_m;
}

double OutlineRefiner::dot_radius_px() const noexcept {
  return camera_.fx_px * landmark_.dot_radius_m / state_.T_camera_landmark.translation_m.norm();
}

OutlineShape OutlineRefiner::shape() const noexcept {
  const auto visible = visible_share();
  const DotAxes dot{dot_radius_px(), foreshortening(state_.T_camera_landmark) * dot_radius_px()};
  OutlineShape shape = shape_of_outlines(pixels_, landmark_, state_, visible, weights_.noise_variance_lsb2, dot);
  shape.centre_ink = centre_ink(pixels_.groups.span(), fits_, weights_);
  const CameraFromLandmark seen = as_exposed(state_.T_camera_landmark, state_.motion, camera_);
  shape.absent = count_absent(luma_, camera_, landmark_, seen, visible, weights_.fit);
  shape.spots = count_spots(luma_, camera_, landmark_, seen, visible, weights_.fit);
  const double blur_px = std::sqrt(std::max(state_.blur_px2, 0.0));
  shape.hollow = count_hollow(luma_, camera_, landmark_, seen, visible, weights_.fit, blur_px);
  return shape;
}

}  // namespace ninedot
