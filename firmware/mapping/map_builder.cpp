// Start values from a tree of links; adjustment with a loss that first tolerates what the tree has accumulated and then
// tightens; sightings beyond the test are left out, and looked at again when the rest has settled without them; at last
// each landmark is asked whether its pictures would rather have it elsewhere, as after a wrong start they do.
#include "mapping/map_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/contract.h"
#include "mapping/adjustment.h"
#include "mapping/chi_square.h"
#include "mapping/map_covariance.h"
#include "mapping/sighting_network.h"
#include "mapping/start_places.h"

namespace ninedot {
namespace {

constexpr double kNoLoss = std::numeric_limits<double>::infinity();
/// The loss tightens by this factor; between, as many steps as a Gauss-Newton method needs to follow.
constexpr double kTightening = 10;
constexpr int kStepsBetween = 10, kStepsAtTheEnd = 50;
/// Of the start's misfits this share is within the first tolerance.
constexpr double kTolerated = 0.9;
/// Rounds of leaving out and taking back, and of moving landmarks elsewhere; both settle after one or two.
constexpr int kMaxTestRounds = 6, kMaxMoveRounds = 3;
/// Neighbours of a landmark: the nearest so many, since a camera has that many in view.
constexpr std::size_t kNeighbours = 3;

class MapBuilder {
 public:
  MapBuilder(std::span<const RecordedSightings> frames, const LandmarkMap& known, const MapBuilderOptions& options)
      : options_(options), network_(make_network(frames, known, options.exact, options.geometry)) {
    sightings_of_.resize(network_.landmarks.size());
    for (std::size_t i = 0; i < network_.sightings.size(); ++i)
      sightings_of_[network_.sightings[i].landmark].push_back(i);
  }

  BuiltMap build() {
    tell("links");
    place_landmarks(network_, find_links(network_));
    place_frames(network_);
    drop_unconnected(network_);
    settle();
    for (int round = 0; round < kMaxMoveRounds && move_misplaced(); ++round) settle();
    return result();
  }

 private:
  void tell(std::string_view what) const {
    if (options_.progress) options_.progress(what);
  }

  void adjust_with(double tolerance, int max_iterations) {
    adjust(network_, {tolerance, max_iterations, [this] { tell("adjustment"); }});
  }

  /// Of a sighting, over its limit [1].
  double misfit(const NetworkSighting& sighting) const {
    return network_.chi2_of(sighting) / chi2_limit(SightingNetwork::freedoms_of(sighting));
  }

  void settle() {
    for (double tolerance = first_tolerance(); tolerance > 1; tolerance = std::max(1.0, tolerance / kTightening))
      adjust_with(tolerance, kStepsBetween);
    adjust_with(1, kStepsAtTheEnd);
    for (int round = 0; round < kMaxTestRounds; ++round) {
      if (!test_sightings() && round > 0) break;
      drop_unconnected(network_);
      adjust_with(kNoLoss, kStepsAtTheEnd);
    }
    factor_ = variance_factor();
  }

  double first_tolerance() const {
    std::vector<double> misfits;
    for (const NetworkSighting& sighting : network_.sightings)
      if (network_.counts(sighting)) misfits.push_back(misfit(sighting));
    if (misfits.empty()) return 1;
    const auto at = misfits.begin() + static_cast<std::ptrdiff_t>(kTolerated * static_cast<double>(misfits.size() - 1));
    std::ranges::nth_element(misfits, at);
    return std::isfinite(*at) ? std::max(1.0, *at) : 1e12;
  }

  /// \return  whether anything has changed
  bool test_sightings() {
    factor_ = variance_factor();
    bool changed = false;
    for (NetworkSighting& sighting : network_.sightings) {
      if (!network_.landmarks[sighting.landmark].placed || !network_.frames[sighting.frame].placed) continue;
      const bool believed = misfit(sighting) <= factor_;
      changed = changed || believed != sighting.believed;
      sighting.believed = believed;
    }
    for (NetworkLandmark& landmark : network_.landmarks) {
      if (!landmark.surveyed || !landmark.placed || chi2_of_survey(landmark) <= chi2_limit(6)) continue;
      contradicted_.push_back(landmark.id);
      landmark.surveyed.reset();
      changed = true;
    }
    return changed;
  }

  /// Robust: the median sighting's chi-square over the median that it should have.
  double variance_factor() const {
    double residuals = 0, unknowns = 0;
    for (const NetworkFrame& frame : network_.frames) unknowns += frame.placed ? 6 : 0;
    for (const NetworkLandmark& landmark : network_.landmarks)
      unknowns += landmark.placed && !landmark.exact && !landmark.surveyed ? 6 : 0;
    for (const NetworkSighting& sighting : network_.sightings)
      if (network_.counts(sighting)) residuals += SightingNetwork::freedoms_of(sighting);
    if (residuals <= unknowns) return 1;
    std::vector<double> ratios;
    for (const NetworkSighting& sighting : network_.sightings) {
      if (!network_.counts(sighting)) continue;
      const double freedoms = SightingNetwork::freedoms_of(sighting) * (1 - unknowns / residuals);
      ratios.push_back(network_.chi2_of(sighting) / chi2_median(std::max(1.0, freedoms)));
    }
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::ranges::nth_element(ratios, middle);
    return std::max(1.0, *middle);
  }

  /// Puts landmarks where more of their pictures agree than where they are. \return  whether there was one
  bool move_misplaced() {
    bool moved = false;
    for (std::size_t i = 0; i < network_.landmarks.size(); ++i) {
      NetworkLandmark& landmark = network_.landmarks[i];
      if (landmark.exact || landmark.surveyed || !has_disagreeing(i)) continue;
      const std::optional<PlaceConsensus> found = place_among_others(network_, i, sightings_of_[i]);
      if (!found || 2 * found->agreeing <= found->pictures) continue;
      const PlaceStep off = step_between(landmark.place, found->place);
      if (landmark.placed && off.dot(found->covariance.inverse() * off) <= factor_ * chi2_limit(6)) continue;
      const WorldFromLandmark before = landmark.place;
      const std::size_t agreed = landmark.placed ? count_fitting(i) : 0;
      landmark.place = found->place;
      if (count_fitting(i) <= agreed) {
        landmark.place = before;
        continue;
      }
      landmark.placed = true;
      for (const std::size_t index : sightings_of_[i]) network_.sightings[index].believed = true;
      moved = true;
    }
    if (moved) {
      tell("misplaced landmarks");
      place_frames(network_);
      drop_unconnected(network_);
    }
    return moved;
  }

  bool has_disagreeing(std::size_t landmark) const {
    return std::ranges::any_of(sightings_of_[landmark],
                               [&](std::size_t index) { return !network_.sightings[index].believed; });
  }

  /// With cameras that may move: how many of a landmark's sightings fit into their pictures.
  std::size_t count_fitting(std::size_t landmark) const {
    std::vector<PlacedSighting> together;
    const auto fits = [&](std::size_t index) {
      const NetworkSighting& sighting = network_.sightings[index];
      together.assign(1, {sighting.seen, network_.landmarks[landmark].place});
      int freedoms = SightingNetwork::freedoms_of(sighting);
      for (const NetworkSighting& other : network_.of(network_.frames[sighting.frame])) {
        if (other.landmark == landmark || !network_.counts(other)) continue;
        together.push_back({other.seen, network_.landmarks[other.landmark].place});
        freedoms += SightingNetwork::freedoms_of(other);
      }
      const WorldFromCamera& camera = network_.frames[sighting.frame].camera;
      return together.size() > 1 &&
             fit_camera(together, camera, network_.geometry).chi2 <= factor_ * chi2_limit(freedoms);
    };
    return static_cast<std::size_t>(std::ranges::count_if(sightings_of_[landmark], fits));
  }

  std::vector<LandmarkPair> neighbours() const {
    std::vector<LandmarkPair> pairs;
    const auto is_back_to_back = [](const WorldFromLandmark& a, const WorldFromLandmark& b) {
      const Eigen::Vector3d to_b = b.translation_m - a.translation_m;
      return a.rotation.col(1).dot(b.rotation.col(1)) < 0 && a.rotation.col(1).dot(to_b) < 0 &&
             b.rotation.col(1).dot(to_b) > 0;
    };
    for (std::size_t i = 0; i < network_.landmarks.size(); ++i) {
      const NetworkLandmark& landmark = network_.landmarks[i];
      std::vector<std::pair<double, std::size_t>> others;
      for (std::size_t j = 0; landmark.placed && j < network_.landmarks.size(); ++j) {
        const NetworkLandmark& other = network_.landmarks[j];
        if (j == i || !other.placed || is_back_to_back(landmark.place, other.place)) continue;
        others.emplace_back((other.place.translation_m - landmark.place.translation_m).norm(), j);
      }
      const std::size_t count = std::min(kNeighbours, others.size());
      std::ranges::partial_sort(others, others.begin() + static_cast<std::ptrdiff_t>(count));
      for (std::size_t k = 0; k < count; ++k) pairs.emplace_back(i, others[k].second);
    }
    return pairs;
  }

  std::optional<WeakestPair> find_weakest(const std::vector<LandmarkPair>& pairs,
                                          const MapCovariance& covariance) const {
    std::optional<WeakestPair> weakest;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto [i, j] = pairs[k];
      const NetworkLandmark &a = network_.landmarks[i], &b = network_.landmarks[j];
      const Eigen::Vector3d d = b.place.translation_m - a.place.translation_m;
      // b seen from a: what b moves, less what a moves, and a's turn takes the whole distance along.
      Eigen::Matrix<double, 3, 6> of_a;
      Eigen::Matrix3d cross;
      cross << 0, -d.z(), d.y(), d.z(), 0, -d.x(), -d.y(), d.x(), 0;
      of_a << -Eigen::Matrix3d::Identity(), cross;
      const Eigen::Matrix3d shared = of_a * covariance.pairs[k].leftCols<3>();
      const double variance_m2 = (of_a * covariance.places[i] * of_a.transpose()).trace() +
                                 covariance.places[j].topLeftCorner<3, 3>().trace() + 2 * shared.trace();
      const double sigma_m = std::sqrt(std::max(0.0, factor_ * variance_m2));
      if (!weakest || sigma_m > weakest->sigma_m) weakest = {a.id, b.id, sigma_m};
    }
    return weakest;
  }

  void find_islands(BuiltMap& map) const {
    std::vector<bool> told(network_.landmarks.size());
    for (std::size_t start = 0; start < network_.landmarks.size(); ++start) {
      if (network_.landmarks[start].placed || told[start]) continue;
      told[start] = true;
      if (sightings_of_[start].empty()) {
        map.unseen.push_back(network_.landmarks[start].id);
        continue;
      }
      std::vector<std::size_t> island{start};
      for (std::size_t at = 0; at < island.size(); ++at)
        for (const std::size_t index : sightings_of_[island[at]])
          for (const NetworkSighting& beside : network_.of(network_.frames[network_.sightings[index].frame]))
            if (!network_.landmarks[beside.landmark].placed && !told[beside.landmark]) {
              told[beside.landmark] = true;
              island.push_back(beside.landmark);
            }
      std::ranges::sort(island);
      auto& ids = map.islands.emplace_back();
      for (const std::size_t landmark : island) ids.push_back(network_.landmarks[landmark].id);
    }
  }

  BuiltMap result() const {
    tell("uncertainties");
    BuiltMap map;
    const std::vector<LandmarkPair> pairs = neighbours();
    const std::optional<MapCovariance> covariance = covariance_of(network_, pairs);
    EXPECTS(covariance.has_value());  // each is joined to a given place by six equations and more
    for (std::size_t i = 0; i < network_.landmarks.size(); ++i) {
      const NetworkLandmark& landmark = network_.landmarks[i];
      if (!landmark.placed) continue;
      map.placed.push_back({landmark.id, {}, landmark.place, true, factor_ * covariance->places[i]});
      map.sighting_counts.push_back(static_cast<std::size_t>(std::ranges::count_if(
          sightings_of_[i], [&](std::size_t index) { return network_.counts(network_.sightings[index]); })));
      map.sightings += map.sighting_counts.back();
    }
    for (const NetworkFrame& frame : network_.frames) map.frames += frame.placed ? 1 : 0;
    for (const NetworkSighting& sighting : network_.sightings) {
      const RecordedSightings& source = *network_.frames[sighting.frame].source;
      if (!sighting.believed)
        map.disagreeing.push_back(
            {source.recording, source.frame, network_.landmarks[sighting.landmark].id, misfit(sighting) / factor_});
    }
    map.disagreeing_surveys = contradicted_;
    map.weakest = find_weakest(pairs, *covariance);
    map.variance_factor = factor_;
    find_islands(map);
    return map;
  }

  const MapBuilderOptions& options_;
  SightingNetwork network_;
  std::vector<std::vector<std::size_t>> sightings_of_;  // of each landmark
  std::vector<std::uint16_t> contradicted_;
  double factor_ = 1;
};

}  // namespace

BuiltMap build_map(std::span<const RecordedSightings> frames, const LandmarkMap& known,
                   const MapBuilderOptions& options) {
  BuiltMap map = MapBuilder(frames, known, options).build();
  for (MappedLandmark& landmark : map.placed) landmark.code = known.find(landmark.id)->code;
  return map;
}

}  // namespace ninedot
