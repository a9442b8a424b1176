#include "pose/light_edge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pose/normal_tail.h"

// A first look takes the light for a slope: a slope points across the edge. Then the edge is put to several places
// along that direction, and from the best one Gauss-Newton goes on, also over direction and width.

namespace ninedot {
namespace {

// Columns: paper and ink before the edge; what both are more beyond it, and ink by itself; then the edge's place [px],
// direction [rad] times the dot's radius, and width [px].
constexpr int kLevels = 4, kColumns = 7;
constexpr std::size_t kLeastPixels = 14;  // twice as many
using Sums = Eigen::Matrix<double, kColumns + 1, kColumns + 1>;
constexpr int kPlaces = 11;               // across the dot: nearer to each other than a dot's radius over five
constexpr int kSteps = 4, kFewSteps = 2;  // of Gauss-Newton at most, and from where the edge was a step ago
constexpr double kSettled_px = 0.01;
// What the model leaves where an edge and an outline cross, over the dot's radius: 0.01 to 0.025 px of dots of 12 px,
// half of that of P9, in noiseless pictures through an sRGB curve, less in linear ones. With 0 errors are 5 % larger
// through the curve, with twice as much 10 % larger without.
constexpr double kMovesRadius_px2 = 0.05;
// And at least, by what no edge has that is Phi in grey levels: penumbras of the sun that a robot drove past moved dots
// of 4 to 8 px by up to 0.06 px. With 0 their poses claim 0.7 of their errors.
constexpr double kLeastMoves_px = 0.02;
constexpr double kPerRoot2Pi = 0.3989422804014327;
constexpr double kUsualWidth_px = 1, kLeastWidth_px = 0.4, kMostWidth_radii = 1;
constexpr double kLongestStep_px = 1.5;
constexpr double kRidge = 1e-3;  // what the pixels say nothing of stays as it is
constexpr double kMostOutside_radii = 1.1;
// Of the larger contrast on both sides, the smaller: a shadow that leaves a twentieth of the light makes it a quarter
// in an sRGB picture. What hides a dot has none.
constexpr double kLeastContrastShare = 0.15;

/// The pixels about their middle.
struct Dot {
  explicit Dot(const LitPixels& p) noexcept : pixels(p) {
    const auto count = static_cast<double>(p.luma.size());
    for (std::size_t i = 0; i < p.luma.size(); ++i)
      middle_px += Eigen::Vector2d(p.x_px[i], p.y_px[i]), mean_lsb += p.luma[i];
    middle_px /= count, mean_lsb /= count;
    double squares = 0;
    for (std::size_t i = 0; i < p.luma.size(); ++i)
      squares += (Eigen::Vector2d(p.x_px[i], p.y_px[i]) - middle_px).squaredNorm();
    radius_px = std::sqrt(2 * squares / count);
  }
  const LitPixels& pixels;
  Eigen::Vector2d middle_px = Eigen::Vector2d::Zero();
  double mean_lsb = 0, radius_px = 0;
};

/// Lower triangle of the products of the first `kCount` columns and the grey levels, which are the last.
/// \param rough  the edge as a ramp, and outlines that cross it as if both were seen sharply: enough to begin with
template <int kCount>
void sum_up(const Dot& dot, const LightEdge& edge, bool rough, Sums& sums) noexcept {
  constexpr auto kGrey = static_cast<std::size_t>(kCount);
  std::array<std::array<double, kGrey + 1>, kGrey + 1> products{};
  const LitPixels& p = dot.pixels;
  const double c_px = edge.offset_px - edge.normal.dot(dot.middle_px), per_width = 1 / edge.width_px;
  for (std::size_t i = 0; i < p.luma.size(); ++i) {
    const double dx = p.x_px[i] - dot.middle_px.x(), dy = p.y_px[i] - dot.middle_px.y();
    const double u = (edge.normal.x() * dx + edge.normal.y() * dy - c_px) * per_width;
    const double ink = p.ink_share[i], paper = 1 - ink;
    double beyond = std::clamp(0.5 + kPerRoot2Pi * u, 0.0, 1.0), both = beyond * ink, density = 0;
    if (!rough) {
      const auto [density_u, tail] = normal_tail(static_cast<float>(u));
      density = density_u;
      beyond = u > 0 ? 1 - tail : tail;
      const double same_way = (edge.normal.x() * p.outward_x_px[i] + edge.normal.y() * p.outward_y_px[i]) * per_width;
      const double densities = density * normal_tail(p.outside[i]).density;
      both = ink_beyond(beyond, ink, u, static_cast<double>(p.outside[i]), densities, std::clamp(same_way, -1.0, 1.0));
    }
    std::array<double, kGrey + 1> row;
    row[0] = paper, row[1] = ink, row[2] = beyond - both + p.lit_ink * both, row[3] = kInkOfItsOwn * both;
    if constexpr (kCount == kColumns) {
      const double step = density * per_width * (edge.paper_lsb * paper + edge.ink_lsb * ink);
      row[4] = -step;
      row[5] = step * (edge.normal.x() * dy - edge.normal.y() * dx) / dot.radius_px;
      row[6] = -step * u;
    }
    row[kGrey] = p.luma[i] - dot.mean_lsb;
    for (std::size_t a = 0; a <= kGrey; ++a)
      for (std::size_t b = 0; b <= a; ++b) products[a][b] += row[a] * row[b];
  }
  sums.setZero();
  for (int a = 0; a <= kCount; ++a)
    for (int b = 0; b <= a; ++b)
      sums(a < kCount ? a : kColumns, b < kCount ? b : kColumns) =
          products[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
}

/// Solves for the first `kCount` columns. \return sum of squared residuals
template <int kCount>
double solve(const Sums& sums, Eigen::Matrix<double, kCount, 1>& found) noexcept {
  Eigen::Matrix<double, kCount, kCount> N = sums.topLeftCorner<kCount, kCount>();
  N.diagonal().array() += kRidge;
  const Eigen::Matrix<double, kCount, 1> b = sums.row(kColumns).template head<kCount>();
  found = N.template selfadjointView<Eigen::Lower>().ldlt().solve(b);
  return sums(kColumns, kColumns) - found.dot(b);
}

using Levels = Eigen::Matrix<double, kLevels, 1>;

void take_levels(const Dot& dot, const Levels& levels, LightEdge& edge) noexcept {
  edge.paper_lsb = levels[2];
  edge.ink_lsb = dot.pixels.lit_ink * levels[2] + kInkOfItsOwn * levels[3];
}

/// Takes the levels that fit an edge best, and what they say of noise and contrast. Above -1 and finite is the contrast
/// only where a dot is in sight on both sides.
void fit_levels(const Dot& dot, bool rough, LightEdge& edge) noexcept {
  Sums sums;
  sum_up<kLevels>(dot, edge, rough, sums);
  Levels levels;
  const double squares = solve<kLevels>(sums, levels);
  take_levels(dot, levels, edge);
  edge.variance_lsb2 = squares / (static_cast<double>(dot.pixels.luma.size()) - kColumns);
  const double before_lsb = levels[0] - levels[1];
  edge.more_contrast = (edge.paper_lsb - edge.ink_lsb) / before_lsb;
}

bool shows_a_dot_on_both_sides(const LightEdge& edge) noexcept {
  const double beyond = 1 + edge.more_contrast;  // of the contrast before it
  return beyond > kLeastContrastShare && beyond < 1 / kLeastContrastShare;
}

/// Where light changes fastest, if it were a slope.
Eigen::Vector2d across(const Dot& dot) noexcept {
  Eigen::Matrix4d N = Eigen::Matrix4d::Identity() * kRidge;
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < dot.pixels.luma.size(); ++i) {
    const double ink = dot.pixels.ink_share[i], paper = 1 - ink;
    const Eigen::Vector4d row(paper, ink, paper * (dot.pixels.x_px[i] - dot.middle_px.x()),
                              paper * (dot.pixels.y_px[i] - dot.middle_px.y()));
    N += row * row.transpose();
    b += row * (dot.pixels.luma[i] - dot.mean_lsb);
  }
  return N.ldlt().solve(b).tail<2>().normalized();
}

LightEdge edge_at(const Dot& dot, const Eigen::Vector2d& normal, double place_px, double width_px) noexcept {
  LightEdge edge;
  edge.normal = normal, edge.offset_px = normal.dot(dot.middle_px) + place_px, edge.width_px = width_px;
  return edge;
}

LightEdge best_of_places(const Dot& dot) noexcept {
  const Eigen::Vector2d normal = across(dot);
  LightEdge best;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kPlaces; ++i) {
    LightEdge edge = edge_at(dot, normal, dot.radius_px * (2.0 * i / (kPlaces - 1) - 1), kUsualWidth_px);
    fit_levels(dot, true, edge);
    if (edge.variance_lsb2 < least) least = edge.variance_lsb2, best = edge;
  }
  return best;
}

}  // namespace

std::optional<LightEdge> find_light_edge(const LitPixels& pixels, const LightEdge* start) noexcept {
  if (pixels.luma.size() < kLeastPixels) return std::nullopt;
  const Dot dot(pixels);
  LightEdge edge = start != nullptr ? *start : best_of_places(dot);
  const int steps = start != nullptr ? kFewSteps : kSteps;
  for (int i = 0; i < steps; ++i) {
    Sums sums;
    sum_up<kColumns>(dot, edge, false, sums);
    Eigen::Matrix<double, kColumns, 1> found;
    (void)solve<kColumns>(sums, found);
    if (!found.allFinite()) return std::nullopt;
    const double place_px = std::clamp(found[4], -kLongestStep_px, kLongestStep_px);
    const double turned_px = std::clamp(found[5], -kLongestStep_px, kLongestStep_px);
    const double wider_px = std::clamp(found[6], -edge.width_px / 2, edge.width_px);
    const double at_px = edge.offset_px - edge.normal.dot(dot.middle_px) + place_px;
    const double turn_rad = turned_px / dot.radius_px;
    const Eigen::Vector2d normal =
        (edge.normal + turn_rad * Eigen::Vector2d(-edge.normal.y(), edge.normal.x())).normalized();
    const double width_px = std::clamp(edge.width_px + wider_px, kLeastWidth_px, kMostWidth_radii * dot.radius_px);
    edge = edge_at(dot, normal, at_px, width_px);
    take_levels(dot, found.head<kLevels>(), edge);
    if (std::abs(at_px) > kMostOutside_radii * dot.radius_px) return std::nullopt;
    if (std::max({std::abs(place_px), std::abs(turned_px), std::abs(wider_px)}) < kSettled_px) break;
  }
  fit_levels(dot, false, edge);
  if (!shows_a_dot_on_both_sides(edge)) return std::nullopt;
  edge.moves_px = std::max(kMovesRadius_px2 / dot.radius_px, kLeastMoves_px);
  return edge;
}

}  // namespace ninedot
