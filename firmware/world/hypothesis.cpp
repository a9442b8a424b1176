#include "world/hypothesis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/contract.h"

namespace ninedot {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Thresholds by which a sighting is beyond doubt another one's.
constexpr double kFarOff = 10;

/// 95 % of chi^2 of six freedoms: what lies within is the same place.
constexpr double kSamePlace_chi2 = 12.592;

/// v M^-1 v: the chi^2 of v where M is its covariance; by how much chi^2 falls to its minimum where v is a gradient and
/// M its normal matrix.
double by_inverse(const Eigen::Matrix<double, 6, 6>& M, const PoseStep& v) noexcept {
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> solver(M);
  return solver.info() == Eigen::Success ? v.dot(solver.solve(v)) : kNever;
}

/// What no model explains, as a covariance of the place of the sighting's landmark.
PoseCovariance unexplained(const Scene& scene, std::size_t sighting) noexcept {
  const double distance_m = scene.own(sighting).T_camera_landmark.translation_m.norm();
  const double position_m = scene.options().unexplained_share * distance_m;
  const double tilt_rad = scene.options().unexplained_tilt_rad;
  PoseCovariance place = PoseCovariance::Zero();
  place.topLeftCorner<3, 3>().diagonal().setConstant(position_m * position_m);
  place.bottomRightCorner<3, 3>().diagonal().setConstant(tilt_rad * tilt_rad);
  return place;
}

/// How far a sighting is from the rest, with what no model explains. Both are taken by their equations at one place of
/// the camera: the minimum over its steps of both together, less each one's own.
double forgiving_chi2(const Scene& scene, std::size_t sighting, const JointMember& member, const SightingFit& fit,
                      const WorldFromCamera& T_world_camera, const PoseInformation& rest_normal,
                      const PoseStep& rest_gradient) noexcept {
  const SightingFit soft =
      softened(fit, step_covariance_of_place(unexplained(scene, sighting), member.T_world_landmark, T_world_camera));
  return soft.chi2 - scene.own(sighting).chi2 + by_inverse(rest_normal, rest_gradient) -
         by_inverse(rest_normal + soft.normal, rest_gradient + soft.gradient);
}

struct Members {
  std::array<JointMember, kMaxSightings> list;
  std::array<std::size_t, kMaxSightings> sightings;  ///< which they are
  std::size_t size = 0;

  void add(const Scene& scene, std::size_t sighting, const Choice& choice) noexcept {
    list[size] = scene.member(sighting, choice);
    sightings[size++] = sighting;
  }
  std::span<const JointMember> span() const noexcept { return {list.data(), size}; }
};

Members members_of(const Scene& scene, const WorldHypothesis& hypothesis) noexcept {
  Members members;
  for (std::size_t i = 0; i < scene.seen().size(); ++i)
    if (hypothesis.choices[i].is_made()) members.add(scene, i, hypothesis.choices[i]);
  return members;
}

/// Member `at` against all others of a joint fit, at whose place the sum of both has its minimum. What no model
/// explains is counted where it decides.
double left_out_chi2(const Scene& scene, const Members& members, const JointFit& fit, std::size_t at) noexcept {
  const PoseInformation rest_normal = fit.sum.normal - fit.of_each[at].normal;
  const PoseStep rest_gradient = fit.sum.gradient - fit.of_each[at].gradient;
  const std::size_t sighting = members.sightings[at];
  const double chi2 = fit.of_each[at].chi2 - scene.own(sighting).chi2 + by_inverse(rest_normal, rest_gradient);
  if (chi2 <= scene.options().max_disagreement_chi2) return chi2;
  return forgiving_chi2(scene, sighting, members.list[at], fit.of_each[at], fit.T_world_camera, rest_normal,
                        rest_gradient);
}

/// The dots' numbering, once for all: there is one camera and one roll, and what several sightings say of it is one
/// statement. The worst of them.
double numbering_cost(const Scene& scene, const WorldHypothesis& hypothesis) noexcept {
  double worst = 0;
  for (std::size_t i = 0; i < scene.seen().size(); ++i) {
    if (!hypothesis.choices[i].is_made() || scene.seen()[i].coded) continue;
    worst = std::max(worst, scene.numbering_cost(i, hypothesis.choices[i]));
  }
  return worst;
}

/// Whether a sighting that a joint fit of it and all others was made with agrees with them.
bool agrees(const Scene& scene, const Members& members, const JointFit& fit, std::size_t at) noexcept {
  return fit.is_determined() && left_out_chi2(scene, members, fit, at) <= scene.options().max_disagreement_chi2;
}

}  // namespace

bool uses(const WorldHypothesis& hypothesis, std::size_t landmark) noexcept {
  return std::ranges::any_of(hypothesis.choices, [&](const Choice& choice) { return choice.landmark == landmark; });
}

void start_alone(const Scene& scene, std::size_t sighting, const Choice& choice, HypothesisList& list) noexcept {
  const SightedLandmark& seen = scene.seen()[sighting];
  WorldHypothesis hypothesis;
  hypothesis.used = 1;
  hypothesis.choices[sighting] = choice;
  hypothesis.T_world_camera = scene.camera_by(scene.own(sighting).T_camera_landmark, choice);
  hypothesis.normal = fit_of_member(scene.member(sighting, choice), hypothesis.T_world_camera, scene.landmark()).normal;
  static_cast<void>(list.try_push_back(hypothesis));
  if (!seen.mirror) return;
  const WorldFromCamera other = scene.camera_by(*seen.mirror, choice);
  if (is_same_place(hypothesis, other)) return;
  hypothesis.T_world_camera = other;
  hypothesis.normal = fit_of_member(scene.member(sighting, choice), other, scene.landmark()).normal;
  hypothesis.crest_chi2 = seen.mirror_chi2_above;
  static_cast<void>(list.try_push_back(hypothesis));
}

bool start_with_pair(const Scene& scene, std::size_t first, const Choice& first_choice, std::size_t second,
                     const Choice& second_choice, HypothesisList& list) noexcept {
  Members pair;
  pair.add(scene, first, first_choice);
  pair.add(scene, second, second_choice);
  InlineVector<WorldFromCamera, 4> starts;
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}}) {
    const std::size_t i = pair.sightings[at];
    const Choice& choice = at == 0 ? first_choice : second_choice;
    static_cast<void>(starts.try_push_back(scene.camera_by(scene.own(i).T_camera_landmark, choice)));
    if (scene.seen()[i].mirror)
      static_cast<void>(starts.try_push_back(scene.camera_by(*scene.seen()[i].mirror, choice)));
  }
  const std::size_t before = list.size();
  const std::size_t of_first = scene.seen()[first].mirror ? 2 : 1;
  for (std::size_t s = 0; s < starts.size(); ++s) {
    if (s == of_first && list.size() > before) break;  // a crest of both is near a crest of the surer one
    JointFit fit;
    fit_jointly(pair.span(), starts[s], scene.landmark(), fit);
    if (!agrees(scene, pair, fit, 1)) continue;
    WorldHypothesis hypothesis;
    hypothesis.T_world_camera = fit.T_world_camera;
    hypothesis.normal = fit.sum.normal;
    hypothesis.used = 2;
    hypothesis.choices[first] = first_choice;
    hypothesis.choices[second] = second_choice;
    if (list.size() > before && is_same_place(list[list.size() - 1], fit.T_world_camera)) continue;
    if (list.size() == before + 2 || !list.try_push_back(hypothesis)) break;
  }
  return list.size() > before;
}

double disagreement_chi2(const Scene& scene, std::size_t sighting, const Choice& choice,
                         const WorldHypothesis& hypothesis) noexcept {
  const JointMember member = scene.member(sighting, choice);
  const SightingFit fit = fit_of_member(member, hypothesis.T_world_camera, scene.landmark());
  if (!std::isfinite(fit.chi2)) return kNever;
  const double chi2 = fit.chi2 - scene.own(sighting).chi2 - by_inverse(hypothesis.normal + fit.normal, fit.gradient);
  if (chi2 <= scene.options().max_disagreement_chi2) return chi2;
  return forgiving_chi2(scene, sighting, member, fit, hypothesis.T_world_camera, hypothesis.normal, PoseStep::Zero());
}

bool try_add(const Scene& scene, std::size_t sighting, const Choice& choice, WorldHypothesis& hypothesis) noexcept {
  EXPECTS(hypothesis.used >= 1);
  const JointMember member = scene.member(sighting, choice);
  const SightingFit fit = fit_of_member(member, hypothesis.T_world_camera, scene.landmark());
  double chi2 = kNever;
  if (std::isfinite(fit.chi2)) {
    const PoseInformation normal = hypothesis.normal + fit.normal;
    const Eigen::LLT<PoseInformation> solver(normal);
    const PoseStep step = -solver.solve(fit.gradient);
    chi2 = fit.chi2 - scene.own(sighting).chi2 + step.dot(fit.gradient);
    if (chi2 <= scene.options().max_disagreement_chi2) {
      hypothesis.T_world_camera = moved_by(hypothesis.T_world_camera, step);
      hypothesis.normal = normal;
      hypothesis.choices[sighting] = choice;
      ++hypothesis.used;
      return true;
    }
  }
  // Far from where the others' equations were made they are no longer true: before it is refused all are asked anew.
  // Three and more fix the place so well that what is far off then is so for good.
  if (hypothesis.used > 2 && chi2 > kFarOff * scene.options().max_disagreement_chi2) return false;
  Members members = members_of(scene, hypothesis);
  members.add(scene, sighting, choice);
  JointFit joint;
  fit_jointly(members.span(), hypothesis.T_world_camera, scene.landmark(), joint);
  if (!agrees(scene, members, joint, members.size - 1)) return false;
  hypothesis.T_world_camera = joint.T_world_camera;
  hypothesis.normal = joint.sum.normal;
  hypothesis.choices[sighting] = choice;
  ++hypothesis.used;
  return true;
}

bool settle(const Scene& scene, WorldHypothesis& hypothesis) noexcept {
  EXPECTS(hypothesis.used >= 1);
  // Of one sighting the grey levels know more than the rays: what they say against a crest counts.
  double disagreement = hypothesis.crest_chi2;
  while (hypothesis.used > 1) {
    const Members members = members_of(scene, hypothesis);
    JointFit fit;
    fit_jointly(members.span(), hypothesis.T_world_camera, scene.landmark(), fit);
    if (!fit.is_determined()) return false;
    hypothesis.T_world_camera = fit.T_world_camera;
    hypothesis.normal = fit.sum.normal;
    disagreement = fit.sum.chi2;
    std::size_t worst = 0;
    for (std::size_t at = 0; at < members.size; ++at) {
      const std::size_t i = members.sightings[at];
      hypothesis.against_rest_chi2[i] = left_out_chi2(scene, members, fit, at);
      disagreement -= scene.own(i).chi2;
      if (hypothesis.against_rest_chi2[i] > hypothesis.against_rest_chi2[members.sightings[worst]]) worst = at;
    }
    const std::size_t i = members.sightings[worst];
    // Of two neither is the worse one.
    if (members.size == 2 || hypothesis.against_rest_chi2[i] <= scene.options().max_disagreement_chi2) break;
    hypothesis.choices[i] = {};
    --hypothesis.used;
  }
  hypothesis.cost = disagreement + numbering_cost(scene, hypothesis);
  if (const WorldPrior* prior = scene.prior(); prior != nullptr) {
    const double chi2 = prior_chi2(*prior, hypothesis);
    const bool is_doubted = prior->doubted && hypothesis.choices[*prior->doubted].is_made();
    hypothesis.agrees_with_prior = chi2 <= scene.options().max_disagreement_chi2;
    hypothesis.prior_cost = cost_by_prior(scene, *prior, is_doubted ? kNever : chi2);
    hypothesis.cost += hypothesis.prior_cost;
  }
  for (std::size_t i = 0; i < scene.seen().size(); ++i)
    if (!hypothesis.choices[i].is_made()) hypothesis.cost += scene.leave_out_cost(i);
  return true;
}

double prior_chi2(const WorldPrior& prior, const WorldHypothesis& hypothesis) noexcept {
  const PoseStep step = step_between(prior.T_world_camera, hypothesis.T_world_camera);
  const PoseCovariance own = hypothesis.normal.llt().solve(PoseInformation::Identity());
  return by_inverse(prior.covariance + own, step);
}

double cost_by_prior(const Scene& scene, const WorldPrior& prior, double chi2) noexcept {
  const double most = scene.options().max_disagreement_chi2;
  return std::min(chi2, prior.ambiguity > 0 ? std::min(most, -2 * std::log(prior.ambiguity)) : most);
}

bool is_same_place(const WorldHypothesis& a, const WorldFromCamera& T_world_camera) noexcept {
  const PoseStep step = step_between(a.T_world_camera, T_world_camera);
  return step.dot(a.normal * step) <= kSamePlace_chi2;
}

}  // namespace ninedot
