#include "mapping/map_covariance.h"

#include <Eigen/LU>
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <map>

#include "mapping/adjustment.h"

namespace ninedot {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Blocks = std::map<LandmarkPair, PlaceCovariance>;

/// What a step of the landmark does to the picture is what this step of the camera does: the camera goes the other way
/// about the landmark.
PlaceCovariance camera_step_for(const WorldFromCamera& camera, const WorldFromLandmark& place) {
  const Eigen::Vector3d arm = camera.translation_m - place.translation_m;
  Eigen::Matrix3d cross;
  cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
  PlaceCovariance A;
  A << -Eigen::Matrix3d::Identity(), cross, Eigen::Matrix3d::Zero(), -camera.rotation.transpose();
  return A;
}

/// One picture's part of the normal equations, its camera eliminated.
void add_frame(const SightingNetwork& network, const NetworkFrame& frame, Blocks& blocks) {
  struct Part {
    std::size_t landmark;
    PlaceCovariance cross;  // camera by landmark
  };
  std::vector<Part> parts;
  PoseInformation of_camera = PoseInformation::Zero();
  for (const NetworkSighting& sighting : network.of(frame)) {
    if (!network.counts(sighting)) continue;
    const NetworkLandmark& landmark = network.landmarks[sighting.landmark];
    const PoseInformation normal =
        fit_of_sighting(*sighting.seen, landmark.place, frame.camera, network.geometry).normal;
    of_camera += normal;
    if (landmark.exact) continue;
    const PlaceCovariance A = camera_step_for(frame.camera, landmark.place);
    parts.push_back({sighting.landmark, normal * A});
    blocks.try_emplace({sighting.landmark, sighting.landmark}, PlaceCovariance::Zero()).first->second +=
        A.transpose() * normal * A;
  }
  if (parts.empty()) return;
  const PoseInformation inverse = of_camera.inverse();
  for (const Part& a : parts)
    for (const Part& b : parts)
      if (a.landmark >= b.landmark)
        blocks.try_emplace({a.landmark, b.landmark}, PlaceCovariance::Zero()).first->second -=
            a.cross.transpose() * inverse * b.cross;
}

}  // namespace

std::optional<MapCovariance> covariance_of(const SightingNetwork& network, const std::vector<LandmarkPair>& pairs) {
  Blocks blocks;
  for (const NetworkFrame& frame : network.frames)
    if (frame.placed) add_frame(network, frame, blocks);
  std::vector<Eigen::Index> column(network.landmarks.size(), -1);
  Eigen::Index unknowns = 0;
  for (std::size_t i = 0; i < network.landmarks.size(); ++i) {
    const NetworkLandmark& landmark = network.landmarks[i];
    if (landmark.exact || !landmark.placed) continue;
    if (landmark.surveyed)
      blocks.try_emplace({i, i}, PlaceCovariance::Zero()).first->second += survey_information(*landmark.surveyed);
    column[i] = unknowns;
    unknowns += 6;
  }

  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(blocks.size() * 36);
  for (const auto& [at, block] : blocks)
    for (Eigen::Index row = 0; row < 6; ++row)
      for (Eigen::Index col = 0; col < 6; ++col)
        if (at.first != at.second || row >= col)
          entries.emplace_back(column[at.first] + row, column[at.second] + col, block(row, col));
  Sparse normal(unknowns, unknowns);
  normal.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLLT<Sparse, Eigen::Lower> factor(normal);
  if (factor.info() != Eigen::Success) return std::nullopt;

  MapCovariance result{std::vector<PlaceCovariance>(network.landmarks.size(), PlaceCovariance::Zero()), {}};
  auto pair = pairs.begin();
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(unknowns, 6), solved;
  for (std::size_t i = 0; i < network.landmarks.size(); ++i) {
    if (column[i] >= 0) {
      unit.middleRows<6>(column[i]).setIdentity();
      solved = factor.solve(unit);
      unit.middleRows<6>(column[i]).setZero();
      result.places[i] = solved.middleRows<6>(column[i]);
    }
    for (; pair != pairs.end() && pair->first == i; ++pair) {
      const Eigen::Index other = column[pair->second];
      result.pairs.emplace_back(PlaceCovariance::Zero());
      if (column[i] >= 0 && other >= 0) result.pairs.back() = solved.middleRows<6>(other).transpose();
    }
  }
  return result;
}

}  // namespace ninedot
