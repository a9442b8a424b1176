#include "calibrate_camera/grid_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <optional>

#include "detect/work_budget.h"

namespace ninedot {
namespace {

/// A grid of which less is seen says little, and chance makes as much out of any texture.
constexpr std::size_t kLeastDots = 16;
/// A neighbour is where it is foretold to this part of a step: a lens that bends changes steps by a tenth at most.
constexpr double kTolerance = 0.22;
/// Large dots have 2.25 times the area of the others. Halfway, as a ratio; and what neighbours may differ by otherwise.
constexpr double kLargeRatio = 1.5;
constexpr double kMostAreaRatio = 4.5;
/// Of the dots that were reached, those beside the grid: texture of the wall that happens to stand where a dot would.
constexpr double kStrangers = 0.15;
/// The search may take its time: twenty times what a frame of the service may cost.
constexpr int kPatience = 20;
/// Blobs that are tried as a first dot.
constexpr std::size_t kSeeds = 40;

using Cell = std::array<int, 2>;  // along the first step, along the second

struct Node {
  std::size_t blob;
  Eigen::Vector2d u, v;  // steps to the neighbours [px]
};

Eigen::Vector2d place(const Blob& blob) { return {blob.x_px, blob.y_px}; }

/// The blob nearest to a place, within a distance; of a size like `like`'s.
std::optional<std::size_t> nearest(const BlobList& blobs, const Eigen::Vector2d& at, double reach_px,
                                   const Blob& like) {
  std::optional<std::size_t> best;
  double best_px = reach_px;
  for (std::size_t i = 0; i < blobs.size(); ++i) {
    const double distance_px = (place(blobs[i]) - at).norm();
    const double ratio = blobs[i].area_px2 / like.area_px2;
    if (distance_px < best_px && ratio < kMostAreaRatio && ratio > 1 / kMostAreaRatio) best = i, best_px = distance_px;
  }
  return best;
}

/// Steps to two neighbours of a dot that are about at right angles, and opposite to which there are neighbours too.
std::optional<Node> seed_at(const BlobList& blobs, std::size_t seed) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < blobs.size(); ++i)
    if (i != seed) order.push_back(i);
  const auto count = std::min<std::size_t>(8, order.size());
  const Eigen::Vector2d at = place(blobs[seed]);
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](std::size_t a, std::size_t b) {
                      return (place(blobs[a]) - at).squaredNorm() < (place(blobs[b]) - at).squaredNorm();
                    });
  order.resize(count);
  const auto has_opposite = [&](const Eigen::Vector2d& step) {
    return nearest(blobs, at - step, kTolerance * step.norm(), blobs[seed]).has_value();
  };
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 1; j < count; ++j) {
      const Eigen::Vector2d u = place(blobs[order[i]]) - at, v = place(blobs[order[j]]) - at;
      const double sine = std::abs(u.x() * v.y() - u.y() * v.x()) / (u.norm() * v.norm());
      const bool has_corner =
          nearest(blobs, at + u + v, kTolerance * std::min(u.norm(), v.norm()), blobs[seed]).has_value();
      if (sine > 0.4 && has_opposite(u) && has_opposite(v) && has_corner) return Node{seed, u, v};
    }
  return std::nullopt;
}

/// All dots that can be reached from the first one.
std::map<Cell, Node> grow(const BlobList& blobs, const Node& seed) {
  std::map<Cell, Node> grid{{{0, 0}, seed}};
  std::vector<bool> used(blobs.size(), false);
  used[seed.blob] = true;
  std::deque<Cell> open{{0, 0}};
  while (!open.empty()) {
    const Cell cell = open.front();
    open.pop_front();
    const Node from = grid.at(cell);
    for (const auto& [du, dv] : {Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}}) {
      const Cell to{cell[0] + du, cell[1] + dv};
      if (grid.contains(to)) continue;
      const Eigen::Vector2d step = du * from.u + dv * from.v;
      const auto blob = nearest(blobs, place(blobs[from.blob]) + step, kTolerance * step.norm(), blobs[from.blob]);
      if (!blob || used[*blob]) continue;
      used[*blob] = true;
      Node node{*blob, from.u, from.v};
      const Eigen::Vector2d made = place(blobs[*blob]) - place(blobs[from.blob]);
      (du != 0 ? node.u : node.v) = (du + dv) * made;
      grid.emplace(to, node);
      open.push_back(to);
    }
  }
  return grid;
}

/// Dots that are larger than the median of their neighbours.
std::vector<Cell> large_cells(const BlobList& blobs, const std::map<Cell, Node>& grid) {
  std::vector<Cell> large;
  for (const auto& [cell, node] : grid) {
    std::vector<float> areas;
    for (int du = -1; du <= 1; ++du)
      for (int dv = -1; dv <= 1; ++dv) {
        const auto other = grid.find({cell[0] + du, cell[1] + dv});
        if ((du != 0 || dv != 0) && other != grid.end()) areas.push_back(blobs[other->second.blob].area_px2);
      }
    if (areas.size() < 3) continue;
    std::ranges::sort(areas);
    if (blobs[node.blob].area_px2 > kLargeRatio * areas[(areas.size() - 1) / 2]) large.push_back(cell);
  }
  return large;
}

/// A quarter turn, `times` times: what is to the right comes to stand below.
Cell turned(Cell cell, int times) {
  for (int i = 0; i < times; ++i) cell = {-cell[1], cell[0]};
  return cell;
}

/// The cells as dots of the printed grid, one reading of several. \return  none: it is not this one
std::vector<SeenDisc> read_as(const BlobList& blobs, const std::map<Cell, Node>& grid, const std::vector<Cell>& large,
                              const DotGrid& printed, const Cell& first, int turn) {
  const auto pattern = printed.large_dots();
  std::vector<SeenDisc> seen;
  std::size_t found = 0;
  for (const auto& [cell, node] : grid) {
    const Cell moved = turned({cell[0] - first[0], cell[1] - first[1]}, turn);
    const auto [column, row] = Cell{moved[0] + pattern[0][0], moved[1] + pattern[0][1]};
    if (column < 0 || row < 0 || column >= printed.columns || row >= printed.rows) continue;
    const bool is_large = std::ranges::find(large, cell) != large.end();
    if (is_large != (std::ranges::find(pattern, Cell{column, row}) != pattern.end())) return {};
    found += is_large ? 1 : 0;
    seen.push_back({printed.index(column, row), place(blobs[node.blob])});
  }
  const bool is_it = found == pattern.size() && seen.size() >= kLeastDots &&
                     static_cast<double>(seen.size()) >= (1 - kStrangers) * static_cast<double>(grid.size());
  return is_it ? seen : std::vector<SeenDisc>{};
}

/// Which dot of the printed grid each cell is. \return  none: the large dots are not those of the grid
std::vector<SeenDisc> numbered(const BlobList& blobs, const std::map<Cell, Node>& grid, const DotGrid& printed) {
  const std::vector<Cell> large = large_cells(blobs, grid);
  for (int turn = 0; turn < 4; ++turn)
    for (const Cell& first : large)
      if (std::vector<SeenDisc> seen = read_as(blobs, grid, large, printed, first, turn); !seen.empty()) return seen;
  return {};
}

}  // namespace

GridFinder::GridFinder(int width_px, int height_px, const DotGrid& grid) : grid_(grid), finder_(width_px, height_px) {}

std::vector<SeenDisc> GridFinder::find(const ImageView& luma) {
  // One level at a time: all dots of a grid are found at one, and their areas can be compared there.
  for (int level = 0; level < BlobFinder::kLevels; ++level) {
    WorkBudget budget;
    budget.regions *= kPatience;
    blobs_.clear();
    finder_.find_blobs(luma, {level, level}, blobs_, budget);
    if (std::vector<SeenDisc> seen = find_among_blobs(); !seen.empty()) return seen;
  }
  return {};
}

std::vector<SeenDisc> GridFinder::find_among_blobs() const {
  // From the largest on: texture is small.
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < blobs_.size(); ++i) order.push_back(i);
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return blobs_[a].area_px2 > blobs_[b].area_px2; });
  std::vector<bool> tried(blobs_.size(), false);
  std::size_t seeds = 0;
  for (const std::size_t i : order) {
    if (tried[i]) continue;
    std::optional<Node> seed = seed_at(blobs_, i);
    if (!seed) continue;
    if (++seeds > kSeeds) break;
    // As the viewer sees it: the second step is a quarter turn to the right of the first.
    if (seed->u.x() * seed->v.y() - seed->u.y() * seed->v.x() < 0) std::swap(seed->u, seed->v);
    const std::map<Cell, Node> grid = grow(blobs_, *seed);
    for (const auto& [cell, node] : grid) tried[node.blob] = true;
    if (grid.size() < kLeastDots) continue;
    if (std::vector<SeenDisc> seen = numbered(blobs_, grid, grid_); !seen.empty()) return seen;
  }
  return {};
}

}  // namespace ninedot
