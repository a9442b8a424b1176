// Weights. What a hypothesis foretold is worth exp(-cost / 2) sqrt(det posterior / det prediction). The motion's part
// of it adds up for good. The pictures' part (chi^2 of the rays) must not: what they have in common would be counted in
// each. It is forgotten at the rate at which they repeat themselves, so that it never exceeds what 1 / common share
// independent pictures would say.
#include "track/pose_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ninedot {
namespace {

constexpr double kPoseFreedoms = 6;
/// chi^2 of so many.
constexpr double kGate_chi2 = 38.3;    // one in a million lies beyond
constexpr double kWithin_chi2 = 12.6;  // 95 %
/// Two crests under one prediction, or two hypotheses, are the same within one sigma of each. [1]
constexpr double kSameCrest_chi2 = 1, kSameMode_chi2 = 4;
/// A reading this near to where a crest's picture would go alone is that crest: to first order it lies there. [1]
constexpr double kSameReading_chi2 = 4;

/// A robot that is first seen drives and turns so fast, 1-sigma of each axis.
constexpr double kStartSpeed_m_s = 1.0, kStartTurning_rad_s = 1.0;
/// A place known no better than this share of the distance to the nearest sheet, all axes together, is none to begin
/// with. What one sheet leaves open is an arc around it: three sigmas along, a Gaussian over places and turns lies
/// beside it by 1.6 % of the distance, which is twice what a lone sheet of 2.5 px dots leaves of that; so wide a one
/// would exclude what lies there. [1]
constexpr double kMaxStartShare = 0.06;

/// So long an error stays what it is while the robot moves: a sheet's place as long as it is in view, a dot's bias
/// until it has gone on by a pixel. [s]
constexpr double kCommonLasts_s = 1.0;

/// Below it a prediction's share on the other side of a sheet's normal is not looked at. [1]
constexpr double kLeastHalf = 1e-4;

constexpr double kMisfitWeight = 0.05;  // of one frame: 20 frames are half a second

/// A frame that lies twice as far from what was foretold as that allows, squared, makes the motion's noise larger by
/// this share, one that agrees better smaller: three frames know a robot that brakes. [1]
constexpr double kUnrestWeight = 0.4;
/// The noise grows no further: accelerations of 30 times what is configured. [1]
constexpr double kMostUnrest = 1000;

double seconds(std::chrono::nanoseconds time) noexcept { return std::chrono::duration<double>(time).count(); }

double distance_chi2(const PoseStep& step, const PoseInformation& covariance) noexcept {
  return step.dot(covariance.llt().solve(step));
}

double nearest_m(const FrameView& frame, const WorldFromCamera& T_world_camera) noexcept {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const JointMember& member : frame.members)
    nearest_m = std::min(nearest_m, (member.T_world_landmark.translation_m - T_world_camera.translation_m).norm());
  return nearest_m;
}

}  // namespace

PoseFilter::PoseFilter(const PoseFilterOptions& options) noexcept : options_(options) {
  const double linear = options.acceleration_sigma_m_s2, angular = options.angular_acceleration_sigma_rad_s2;
  noise_ = {linear * linear * kManoeuvre_s, angular * angular * kManoeuvre_s};
}

void PoseFilter::reset() noexcept {
  modes_.clear();
  gated_ = 0;
  misfit_ = 1;
}

// What the rays miss beyond their stated sigma, frame after frame, is no noise of a picture: it is all common.
ErrorShares PoseFilter::shares() const noexcept {
  return {1 - options_.common_share, options_.common_share + misfit_ - 1};
}

FilterVerdict PoseFilter::take(MonoTime exposed_at, std::span<const JointMember> members,
                               std::span<const WorldReading> readings) noexcept {
  if (has_frame_ && exposed_at <= newest_at_) return FilterVerdict::kTooLate;
  const double dt_s = seconds(exposed_at - newest_at_);
  has_frame_ = true;
  newest_at_ = exposed_at;
  if (!modes_.empty() && exposed_at - believed_at_ > kMaxSilence) reset();
  for (PoseMode& mode : modes_) mode.predict(dt_s, noise(), kCommonLasts_s);

  if (members.empty()) return FilterVerdict::kNothing;
  const FrameView frame{members, options_.landmark};
  readings = readings.first(std::min(readings.size(), kMaxReadings));
  if (modes_.empty()) return start(exposed_at, frame, readings);

  const Parents parents = parents_for(frame);
  Children children;
  find_crests(frame, readings, parents, children);
  if (children.empty()) {
    if (++gated_ < kMaxGated) return FilterVerdict::kGated;
    reset();
    return start(exposed_at, frame, readings);
  }
  gated_ = 0;
  believed_at_ = exposed_at;
  follow(children, parents);
  return FilterVerdict::kTaken;
}

FilterVerdict PoseFilter::start(MonoTime exposed_at, const FrameView& frame,
                                std::span<const WorldReading> readings) noexcept {
  for (const WorldReading& reading : readings) {
    const auto crest =
        climb(frame, reading.turn, shares().own, {reading.T_world_camera}, reading.T_world_camera, kGate_chi2);
    if (!crest || modes_.full()) continue;
    // A crest that says too little to begin with is not excluded by that: the others would seem to be alone.
    const double sigma_m = std::sqrt(crest->covariance.topLeftCorner<3, 3>().trace());
    if (sigma_m > kMaxStartShare * nearest_m(frame, crest->T_world_camera)) {
      modes_.clear();
      return FilterVerdict::kNothing;
    }
    PoseMode mode = mode_at_rest(*crest, reading.turn, shares(), kStartSpeed_m_s, kStartTurning_rad_s);
    mode.log_motion = -reading.chi2_above / 2;
    static_cast<void>(modes_.try_push_back(mode));
  }
  if (modes_.empty()) return FilterVerdict::kNothing;
  tidy();
  gated_ = 0;
  believed_at_ = exposed_at;
  return FilterVerdict::kStarted;
}

// One sheet alone looks the same from both sides of its normal, nearly. A prediction that reaches over the normal is
// cut there: linearised on one side, a picture would seem to exclude what lies on the other, which it does not.
PoseFilter::Parents PoseFilter::parents_for(const FrameView& frame) const noexcept {
  Parents parents;
  for (const PoseMode& mode : modes_) {
    std::optional<std::array<PoseMode, 2>> halves;
    if (frame.members.size() == 1) {
      const WorldFromLandmark& place = frame.members[0].T_world_landmark;
      const Eigen::Vector3d normal = place.rotation.col(1);
      const Eigen::Vector3d from_sheet_m = mode.motion.T_world_camera.translation_m - place.translation_m;
      const Eigen::Vector3d aside_m = from_sheet_m - normal.dot(from_sheet_m) * normal;
      halves = mode.halved(place.translation_m, aside_m.normalized(), kLeastHalf);
    }
    static_cast<void>(parents.try_push_back(halves ? (*halves)[0] : mode));
    if (halves) static_cast<void>(parents.try_push_back((*halves)[1]));
  }
  return parents;
}

void PoseFilter::find_crests(const FrameView& frame, std::span<const WorldReading> readings, const Parents& parents,
                             Children& children) const noexcept {
  const ErrorShares errors = shares();
  for (std::size_t parent = 0; parent < parents.size(); ++parent) {
    const PoseMode& mode = parents[parent];
    const std::optional<ForetoldPose> foretold = foretold_pose(mode);
    if (!foretold) continue;
    const std::size_t first = children.size();
    const auto climb_from = [&](const WorldFromCamera& start) {
      const auto crest = climb(frame, mode.turn, errors.own, *foretold, start, kGate_chi2);
      if (!crest || !(crest->surprise_chi2 <= kGate_chi2)) return;  // nor one that is not finite
      for (std::size_t i = first; i < children.size(); ++i) {
        const Crest& known = children[i].crest;
        const PoseStep apart = step_between(known.T_world_camera, crest->T_world_camera);
        if (distance_chi2(apart, known.covariance) < kSameCrest_chi2) return;
      }
      const double log_picture =
          mode.log_picture * errors.own / (errors.own + errors.common) - crest->fit.sum.chi2 / (2 * misfit_);
      static_cast<void>(children.try_push_back({*crest, parent, mode.log_motion + crest->log_motion, log_picture}));
    };
    climb_from(mode.motion.T_world_camera);
    for (const WorldReading& reading : readings) {
      if (reading.turn != mode.turn) continue;
      const PoseStep step = step_between(foretold->T_world_camera, reading.T_world_camera);
      const bool is_known = std::any_of(children.begin() + first, children.end(), [&](const Child& child) {
        const PoseStep apart = step_between(child.crest.T_world_camera, reading.T_world_camera) - child.crest.apart;
        return apart.dot(child.crest.fit.sum.normal * apart) < kSameReading_chi2;
      });
      // Out of reach: its crest, if there is one, would be gated.
      if (is_known || distance_chi2(step, foretold->covariance) > 4 * kGate_chi2) continue;
      climb_from(reading.T_world_camera);
    }
  }
}

void PoseFilter::follow(Children& children, const Parents& parents) noexcept {
  std::sort(children.begin(), children.end(),
            [](const Child& a, const Child& b) { return a.log_weight() > b.log_weight(); });
  const ErrorShares errors = shares();
  modes_.clear();
  for (const Child& child : children) {
    if (modes_.full()) break;
    PoseMode mode = parents[child.parent];
    mode.settle(child.crest, errors);
    mode.log_motion = child.log_motion;
    mode.log_picture = child.log_picture;
    static_cast<void>(modes_.try_push_back(mode));
  }
  note_fit(children[0].crest);
  note_surprise(children[0].crest.surprise_chi2);
  tidy();
}

void PoseFilter::note_fit(const Crest& crest) noexcept {
  const int freedoms = 2 * crest.fit.sum.dots - 6;
  if (freedoms <= 0) return;
  misfit_ += kMisfitWeight * (crest.alone_chi2 / freedoms - misfit_);
  misfit_ = std::fmax(misfit_, 1);
}

/// \param chi2  of a picture against what was foretold [1]
void PoseFilter::note_surprise(double chi2) noexcept {
  unrest_ = std::clamp(unrest_ * (1 + kUnrestWeight * (chi2 / kPoseFreedoms - 1)), 1.0, kMostUnrest);
}

MotionNoise PoseFilter::noise() const noexcept {
  return {unrest_ * noise_.linear_m2_s3, unrest_ * noise_.angular_rad2_s3};
}

// Merges what coincides, drops what is out of the question, and makes the weights sum to one.
void PoseFilter::tidy() noexcept {
  std::sort(modes_.begin(), modes_.end(),
            [](const PoseMode& a, const PoseMode& b) { return a.log_weight() > b.log_weight(); });
  const double best_log = modes_[0].log_weight();
  InlineVector<PoseMode, kMaxModes> kept;
  double sum = 0;
  for (PoseMode& mode : modes_) {
    mode.log_motion -= best_log;
    const double weight = std::exp(mode.log_weight());
    if (weight < kLeastWeight) continue;
    sum += weight;
    bool is_same = false;
    for (PoseMode& other : kept) {
      if (other.turn != mode.turn) continue;
      const MotionStep apart = step_between(other.motion, mode.motion);
      if (apart.dot(other.covariance.llt().solve(apart)) > kSameMode_chi2) continue;
      const double other_weight = std::exp(other.log_weight()), share = weight / (weight + other_weight);
      other.covariance +=
          share * (mode.covariance - other.covariance) + share * (1 - share) * apart * apart.transpose();
      other.common_covariance += share * (mode.common_covariance - other.common_covariance);
      other.common_cross += share * (mode.common_cross - other.common_cross);
      other.motion = moved_by(other.motion, share * apart);
      other.log_motion += std::log1p(weight / other_weight);
      is_same = true;
      break;
    }
    if (!is_same) static_cast<void>(kept.try_push_back(mode));
  }
  for (PoseMode& mode : kept) mode.log_motion -= std::log(sum);
  modes_ = kept;
}

bool PoseFilter::can_answer(MonoTime time) const noexcept {
  return !modes_.empty() && time >= newest_at_ && time - believed_at_ <= kMaxSilence;
}

std::optional<TrackedPose> PoseFilter::at(MonoTime time) const noexcept {
  if (!can_answer(time)) return {};
  const double dt_s = seconds(time - newest_at_);
  TrackedPose tracked{.at = time, .gated_frames = gated_, .misfit = misfit_};
  MotionCovariance own = MotionCovariance::Zero();
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    PoseMode mode = modes_[i];
    if (dt_s > 0) mode.predict(dt_s, noise(), kCommonLasts_s);
    if (i == 0) {
      tracked.motion = mode.motion;
      own = mode.whole_covariance();
    }
    const double weight = std::exp(mode.log_weight());
    const MotionStep apart = step_between(tracked.motion, mode.motion);
    tracked.covariance += weight * (mode.whole_covariance() + apart * apart.transpose());
    if (i > 0 &&
        (mode.turn != modes_[0].turn || distance_chi2(apart.head<6>(), own.topLeftCorner<6, 6>()) > kWithin_chi2))
      tracked.ambiguity += weight;
  }
  return tracked;
}

std::optional<PoseFilter::Forecast> PoseFilter::forecast(MonoTime time) const noexcept {
  if (!can_answer(time)) return {};
  PoseMode mode = modes_[0];
  if (const double dt_s = seconds(time - newest_at_); dt_s > 0) mode.predict(dt_s, noise(), kCommonLasts_s);
  const double ambiguity = at(time)->ambiguity;  // it can answer
  return Forecast{mode.motion.T_world_camera, mode.whole_covariance().topLeftCorner<6, 6>(), ambiguity};
}

}  // namespace ninedot
