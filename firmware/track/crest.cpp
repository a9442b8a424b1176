#include "track/crest.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "world/scene.h"

namespace ninedot {
namespace {

/// From a prediction two steps settle; from the mirror image's far side of a lone sheet it may take eight.
constexpr int kMaxSteps = 12, kMaxHalvings = 4;
/// A step this small against the posterior's sigma, squared, is not worth another look at the picture. [1]
constexpr double kSettled_chi2 = 1e-4;
/// Keeps pictures that leave a freedom open decomposable: of the information's diagonal. [1]
constexpr double kOpenShare = 1e-9;

double half_log_determinant(const Eigen::LLT<PoseInformation>& root) noexcept {
  return root.matrixLLT().diagonal().array().log().sum();
}

/// A place on the way up, looked at.
struct Place {
  WorldFromCamera T_world_camera;
  FrameFit fit;
  PoseStep moved;  // from the foretold pose
  double cost = 0;
};

Place look(const FrameView& frame, std::size_t turn, double own_share, const ForetoldPose& foretold,
           const WorldFromCamera& T_world_camera) noexcept {
  Place place{T_world_camera, frame.fit_at(T_world_camera, turn),
              step_between(foretold.T_world_camera, T_world_camera)};
  place.cost = place.fit.sum.chi2 / own_share + place.moved.dot(foretold.information * place.moved);
  return place;
}

}  // namespace

Eigen::LLT<PoseInformation> root_of(const PoseInformation& information) noexcept {
  PoseInformation kept = information;
  kept.diagonal() *= 1 + kOpenShare;
  return kept.llt();
}

FrameFit FrameView::fit_at(const WorldFromCamera& T_world_camera, std::size_t turn) const noexcept {
  FrameFit all;
  for (const JointMember& member : members) {
    WorldFromLandmark place = member.T_world_landmark;
    if (turn != 0) place.rotation *= axes_of_turn(turn).transpose();
    const SightingFit fit = fit_of_sighting(*member.sighting, place, T_world_camera, landmark);
    all.with_exact_places += fit.normal;
    all.sum += member.place_covariance == nullptr
                   ? fit
                   : softened(fit, step_covariance_of_place(*member.place_covariance, place, T_world_camera));
  }
  return all;
}

std::optional<Crest> climb(const FrameView& frame, std::size_t turn, double own_share, const ForetoldPose& foretold,
                           const WorldFromCamera& start, double max_surprise_chi2) noexcept {
  Place at = look(frame, turn, own_share, foretold, start);
  Eigen::LLT<PoseInformation> root;
  for (int step_number = 0;; ++step_number) {
    if (!std::isfinite(at.cost) || at.fit.sum.dots == 0) return {};
    root = root_of(foretold.information + at.fit.sum.normal / own_share);
    if (root.info() != Eigen::Success) return {};
    if (step_number == kMaxSteps) break;
    // To first order in the turn since the prediction: its own Jacobian is one within half of that turn.
    const PoseStep slope = foretold.information * at.moved + at.fit.sum.gradient / own_share;
    PoseStep step = -root.solve(slope);
    if (!step.allFinite()) return {};
    if (-step.dot(slope) < kSettled_chi2) break;
    Place next = look(frame, turn, own_share, foretold, moved_by(at.T_world_camera, step));
    for (int halving = 0; halving < kMaxHalvings && !(next.cost <= at.cost); ++halving) {
      step /= 2;
      next = look(frame, turn, own_share, foretold, moved_by(at.T_world_camera, step));
    }
    if (!(next.cost <= at.cost)) break;
    at = next;
  }
  Crest crest{.T_world_camera = at.T_world_camera, .fit = at.fit, .moved = at.moved};
  crest.covariance = root.solve(PoseCovariance::Identity());
  // At the crest the prediction pulls as hard as the picture: by `apart` the picture alone would go on.
  const PoseStep pull = at.fit.sum.gradient / own_share;
  const Eigen::LLT<PoseInformation> alone = root_of(at.fit.sum.normal / own_share);
  crest.apart = -alone.solve(pull);
  const double motion_chi2 = at.moved.dot(foretold.information * at.moved), gain_chi2 = -pull.dot(crest.apart);
  crest.alone_chi2 = std::fmax(0, at.fit.sum.chi2 - gain_chi2 * own_share);
  crest.log_motion = -motion_chi2 / 2 + foretold.log_density - half_log_determinant(root);
  // The same with what the prediction's pictures had in common, which a picture of other sheets brings to light.
  crest.surprise_chi2 = motion_chi2 + gain_chi2;
  if (crest.surprise_chi2 > max_surprise_chi2) {
    const PoseStep whole = at.moved + crest.apart;
    const PoseCovariance both = foretold.covariance + PoseCovariance(alone.solve(PoseCovariance::Identity()));
    crest.surprise_chi2 = std::fmin(crest.surprise_chi2, whole.dot(both.llt().solve(whole)));
  }
  return crest;
}

}  // namespace ninedot
