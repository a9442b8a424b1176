#include "track/track.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/contract.h"
#include "pose/mirror_image.h"
#include "track/reading_odds.h"

namespace ninedot {
namespace {

// A landmark whose motion is foretold no better than this is found sooner by the detector than by its outlines: half of
// the reach within which an expectation's first step leads to the outline (pose/outline_refiner.cpp).
constexpr double kLittleSurprise_px = 0.5;
// Of what the last frame was off by, so much is taken for acceleration that goes on: the rest is noise of three poses.
constexpr double kLastingShare = 0.5;
constexpr double kUsableSurprise_px = 12;  // the least margin around the window of a search (detect/detector.cpp)
constexpr double kSettled = 1e-4;  // weight of the mirror image in a track that has told the two planar solutions apart

// How fast a robot, or a head on it, turns before a landmark: half a turn in three seconds, 1-sigma.
constexpr double kUsualRate_rad_s = 1;

// What differences of two and of three frames make of the noise of a landmark's direction; and that noise where its
// outlines do not tell.
constexpr double kNoiseOfTwo = 1.5, kNoiseOfThree = 2.5, kRayNoise_px = 0.05;

// For so long the numbers of a landmark's dots are remembered while it is out of sight: in a second a head or a robot
// that is out of sight does not roll by more than the 8 degrees at which a forecast is still met (detect/numbering.h).
constexpr std::chrono::seconds kRemembered{1};
// Odds of 20 to 1: a track that began with a wrong numbering ends some degrees after the camera comes nearer to level
// than it was; one that began level is kept up to a roll of 46 degrees, with 5 degrees as the roll's sigma.
constexpr double kRefuted_chi2 = 6;
// A turn in the sheet's own plane by more than half an eighth: what the track's way said of its numbers says nothing of
// these.
constexpr double kOtherNumbers_rad = std::numbers::pi / 8;

/// Where colours tell which dot is P1: a chi^2 of which nothing is left, for all other numberings.
constexpr NumberingCosts kNoOtherNumbering{0, 1000, 1000, 1000, 1000, 1000, 1000, 1000};

/// Of `now` against `before`, about the sheet's normal.
double turn_in_plane_rad(const CameraFromLandmark& before, const CameraFromLandmark& now) noexcept {
  const Eigen::Matrix3d turn = before.rotation.transpose() * now.rotation;
  return std::atan2(turn(0, 2) - turn(2, 0), turn(0, 0) + turn(2, 2));
}

/// The rate of a turn that was measured with `spread_rad2`: where tilts are known poorly, most of a difference of two
/// is noise. Bayes, both Gaussian.
Eigen::Vector3d believed_rate(const Eigen::Vector3d& turn_rad, const Eigen::Matrix3d& spread_rad2,
                              double since_s) noexcept {
  const double usual_rad2 = std::pow(kUsualRate_rad_s * since_s, 2);
  const Eigen::Matrix3d total_rad2 = spread_rad2 + usual_rad2 * Eigen::Matrix3d::Identity();
  return usual_rad2 / since_s * total_rad2.llt().solve(turn_rad);
}

/// 1-sigma of the direction to a landmark, each axis, by its dots [1]. None: they do not tell.
std::optional<double> ray_sigma_of(const DotSightings& dots) noexcept {
  double information = 0;
  for (const DotSighting& dot : dots) information += dot.information.trace() / 2;
  return information > 0 ? std::optional(1 / std::sqrt(information)) : std::nullopt;
}

}  // namespace

bool is_publishable(const PoseEstimate& pose) noexcept {
  const EllipseParameters& e = pose.ellipse;
  const double sum = e.swing_psi_rad + e.tilt_phi_rad + e.pan_theta_rad + e.distance_m + e.image_distance_m +
                     e.deviation_rad + pose.ambiguity + pose.rms_px;
  return std::isfinite(sum) && pose.T_landmark_camera.rotation.allFinite() &&
         pose.T_landmark_camera.translation_m.allFinite() && pose.covariance.allFinite() &&
         (pose.covariance.diagonal().array() > 0).all();
}

CameraFromLandmark Track::expected_at(MonoTime time) const noexcept {
  EXPECTS(has_pose_);
  CameraFromLandmark T = prior_.T_camera_landmark;
  if (!motion_) return T;
  const double ahead_s = std::chrono::duration<double>(time - pose_at_).count();
  T.rotation = exp_so3(ahead_s * motion_->rotation_rad_s) * T.rotation;
  T.translation_m += ahead_s * motion_->translation_m_s;
  // The motion was that of the middle between the two frames.
  T.translation_m.head<2>() +=
      0.5 * ahead_s * (ahead_s + motion_->over_s) * T.translation_m.z() * motion_->acceleration_1_s2;
  return T;
}

std::optional<SheetMotion> Track::motion_at(MonoTime time) const noexcept {
  if (!motion_ || !motion_->is_own()) return std::nullopt;
  SheetMotion motion{motion_->rotation_rad_s, motion_->translation_m_s};
  const double since_s = std::chrono::duration<double>(time - pose_at_).count() + 0.5 * motion_->over_s;
  motion.translation_m_s.head<2>() += since_s * prior_.T_camera_landmark.translation_m.z() * motion_->acceleration_1_s2;
  return motion;
}

std::optional<MeasuredMotion> Track::motion_now() const noexcept {
  if (!motion_ || !motion_->is_own()) return std::nullopt;
  const double noise_1 = (motion_->gain ? kNoiseOfThree : kNoiseOfTwo) * motion_->ray_sigma_1;
  return MeasuredMotion{
      {motion_->rotation_rad_s, motion_->now_m_s}, noise_1 / motion_->over_s, motion_->over_s, motion_->gain};
}

std::optional<SheetMotion> Track::motion_across(const Eigen::Vector2d& ray, MonoTime time) const noexcept {
  if (!has_pose_ || time <= pose_at_) return std::nullopt;
  const Eigen::Vector3d& t_m = prior_.T_camera_landmark.translation_m;
  SheetMotion motion;
  motion.translation_m_s.head<2>() =
      t_m.z() * (ray - t_m.hnormalized()) / std::chrono::duration<double>(time - pose_at_).count();
  return motion;
}

void Track::foretell(const SheetMotion& motion) noexcept {
  if (!has_pose_) return;
  if (!motion_) motion_ = Motion{.translation_m_s = motion.translation_m_s};
  motion_->rotation_rad_s = motion.rotation_rad_s;
}

LandmarkForecast Track::forecast(MonoTime time) const noexcept {
  EXPECTS(has_sighting_);
  const auto numbers = numbering_is_known_ ? ForecastNumbers::kCertain : ForecastNumbers::kForetold;
  if (!has_pose_ || !options_.pose_foretells) return {sighting_, numbers};
  // A motion that foretold nothing the last time is none: unrelated pictures, or a pose of another reading.
  return {surprise_px_ < kUsableSurprise_px ? expected_at(time) : prior_.T_camera_landmark, numbers};
}

std::optional<LandmarkForecast> Track::remembered(MonoTime time) const noexcept {
  if (!has_past_ || time - pose_at_ > kRemembered) return std::nullopt;
  return LandmarkForecast(prior_.T_camera_landmark);
}

void Track::reset() noexcept { *this = Track(options_); }

bool Track::is_numbering_refuted() const noexcept {
  return !numbering_is_known_ && has_past_ &&
         numbering_worst_[0] - *std::ranges::min_element(numbering_worst_) > kRefuted_chi2;
}

void Track::note_numbering() noexcept {
  const NumberingCosts costs = upright_costs(prior_.T_camera_landmark, options_.landmark, options_.upright);
  for (std::size_t k = 0; k < costs.size(); ++k)
    numbering_worst_[k] = has_past_ ? std::max(numbering_worst_[k], costs[k]) : costs[k];
  has_past_ = true;
}

bool Track::may_follow_outlines() const noexcept { return has_pose_ && surprise_px_ < kLittleSurprise_px; }

PoseExpectation Track::expectation(MonoTime exposed_at) const noexcept { return {expected_at(exposed_at), pose_}; }

void Track::see(const LandmarkObservation& seen) noexcept {
  sighting_ = seen;
  has_sighting_ = true;
}

std::size_t Track::choose(const PoseCandidates& candidates) const noexcept {
  std::size_t chosen = 0;
  if (!has_pose_) return chosen;
  const auto turn_rad = [&](const PoseCandidate& c) {
    return angle_between_rad(prior_.T_camera_landmark, c.pose.T_landmark_camera.inverse());
  };
  for (std::size_t i = 1; i < candidates.list.size(); ++i) {
    const PoseCandidate& c = candidates.list[i];
    if (c.refined && c.chi2_above < kUndecided_chi2 && turn_rad(c) < turn_rad(candidates.list[chosen])) chosen = i;
  }
  return chosen;
}

Result<std::size_t> Track::take(PoseCandidates& candidates, MonoTime exposed_at) noexcept {
  const std::size_t chosen = choose(candidates);
  PoseCandidate& candidate = candidates.list[chosen];
  if (!is_publishable(candidate.pose)) {
    lose_pose(true);
    return fail(Errc::kPoseDegenerate, "the pose or its covariance is not finite");
  }
  const CameraFromLandmark now = note_motion(candidate, exposed_at);
  if (!remembered(exposed_at) || std::abs(turn_in_plane_rad(prior_.T_camera_landmark, now)) > kOtherNumbers_rad)
    has_past_ = false;
  const NumberingCosts past = numbering_is_known_ ? kNoOtherNumbering : has_past_ ? numbering_worst_ : NumberingCosts{};
  const ReadingOdds odds =
      weigh_readings(candidates, chosen, past, options_.landmark, numbering_is_known_ ? nullptr : &options_.upright);
  candidate.pose.ambiguity = odds.ambiguity;
  candidates.rival = odds.rival;
  mirror_weight_ = odds.mirror_weight;
  has_pose_ = true;
  pose_ = candidate.pose;
  pose_at_ = exposed_at;
  prior_ = {now, candidate.outlines, candidates.warp_px, mirror_weight_ < kSettled};
  if (motion_ && motion_->is_own()) prior_.outlines.motion.translation_m_s = motion_->now_m_s;
  note_numbering();
  return chosen;
}

void Track::believe(PoseCandidates& candidates, std::size_t chosen) noexcept {
  const PoseCandidate& candidate = candidates.list[chosen];
  const CameraFromLandmark now = candidate.pose.T_landmark_camera.inverse();
  mirror_weight_ = 0;
  prior_.side_is_settled = true;
  if (angle_between_rad(now, prior_.T_camera_landmark) < kSamePose_rad) return;
  motion_.reset();
  pose_ = candidate.pose;
  prior_.T_camera_landmark = now;
  prior_.outlines = candidate.outlines;
}

void Track::jump() noexcept {
  has_jumped_ = has_pose_;
  lose_pose(false);
}

void Track::lose_pose(bool sighted) noexcept {
  has_sighting_ = sighted;
  has_pose_ = false;
  motion_.reset();
  surprise_px_ = 0;
}

/// When a landmark's own rows are exposed, after the middle one. The principal point is about in the middle.
double Track::rows_after_middle_s(const CameraFromLandmark& T, const SheetMotion& motion) const noexcept {
  return options_.focal_px * T.translation_m.y() / T.translation_m.z() * motion.row_time_s;
}

/// The motion since the frame before, and how well it was foretold. A fit that took another motion for its rows' than
/// they had (none, in a track's first two frames) has the landmark where it was when those were exposed.
/// \return  where it was at the middle row
CameraFromLandmark Track::note_motion(const PoseCandidate& fitted, MonoTime exposed_at) noexcept {
  CameraFromLandmark now = fitted.pose.T_landmark_camera.inverse();
  const double since_s = std::chrono::duration<double>(exposed_at - pose_at_).count();
  if (!has_pose_ || !(since_s > 0)) {
    motion_.reset();
    surprise_px_ = has_jumped_ ? std::numeric_limits<double>::infinity() : 0;
    has_jumped_ = false;
    return now;
  }
  const CameraFromLandmark& before = prior_.T_camera_landmark;
  const auto direction = [](const Eigen::Vector3d& p_camera_m) -> Eigen::Vector2d { return p_camera_m.hnormalized(); };
  const Eigen::Vector2d surprise = direction(now.translation_m) - direction(expected_at(exposed_at).translation_m);
  surprise_px_ = options_.focal_px * surprise.norm();
  if (std::abs(turn_in_plane_rad(before, now)) > kOtherNumbers_rad) {
    motion_.reset();  // as if it turned by so much in every frame
    return now;
  }
  // v t = (now - rows (v - v taken)) - (before - its rows (v - v taken before))
  const SheetMotion &taken = fitted.outlines.motion, &taken_before = prior_.outlines.motion;
  const double rows_s = rows_after_middle_s(now, taken), rows_before_s = rows_after_middle_s(before, taken_before);
  const Eigen::Vector3d way_m = now.translation_m + rows_s * taken.translation_m_s - before.translation_m -
                                rows_before_s * taken_before.translation_m_s;
  const Eigen::Vector3d turn_rad = log_so3(now.rotation * before.rotation.transpose());
  const Eigen::Matrix3d spread_rad2 =
      pose_.covariance.bottomRightCorner<3, 3>() + fitted.pose.covariance.bottomRightCorner<3, 3>();
  Motion motion{believed_rate(turn_rad, spread_rad2, since_s), way_m / (since_s + rows_s - rows_before_s), since_s};
  motion.now_m_s = motion.translation_m_s;
  motion.ray_sigma_1 = ray_sigma_of(fitted.dots).value_or(kRayNoise_px / options_.focal_px);
  if (motion_ && motion_->is_own()) {
    const Eigen::Vector2d change_1_s2 = 2 / (since_s * (since_s + motion_->over_s)) * surprise;
    // What is too surprising is measured, but does not go on.
    if (surprise_px_ < kUsableSurprise_px)
      motion.acceleration_1_s2 = motion_->acceleration_1_s2 + kLastingShare * change_1_s2;
    // At this frame, not at the middle of the two: from there on it gained speed for half of the time between them.
    motion.gain = {motion_->acceleration_1_s2 + change_1_s2, change_1_s2};
    motion.now_m_s.head<2>() += 0.5 * since_s * now.translation_m.z() * motion.gain->acceleration_1_s2;
  }
  motion_ = motion;
  now.translation_m -= rows_s * (motion.now_m_s - taken.translation_m_s);
  return now;
}

}  // namespace ninedot
