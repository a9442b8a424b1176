#include "colour/sheet_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/contract.h"
#include "base/inline_vector.h"
#include "colour/blocks.h"

namespace ninedot {
namespace {

constexpr int kUnknowns = kDotCount + 3;  // the dots' steps from paper to ink, the paper, its slope in both directions
constexpr int kPaper = kDotCount;
using Row = Eigen::Matrix<float, kUnknowns, 1>;
using Normal = Eigen::Matrix<float, kUnknowns, kUnknowns>;
using Solution = Eigen::Matrix<float, kUnknowns, 3>;  // of red, green and blue

/// Of sum (cover - what the others have of it)^2. Below, where a dot lies on the sensor's pattern says more than its
/// ink: of rendered rings of 2.0 and 2.2 px 4 of 190 were named wrongly down to 0.03, none of 155 with this. [1]
constexpr float kLeastSpread = 0.06F;
constexpr float kRidge = 1e-3F;  // a dot that no block sees has a step of no size, and no certainty

/// A block of pixels: what it gets its light from, and its light.
struct Sample {
  Row from;
  Eigen::Vector3f light;
};
constexpr std::size_t kMostSamples = 256;  // the sheet of dots of 2 px in radius has 190, and of larger ones a part
using Samples = InlineVector<Sample, kMostSamples>;

/// Radius of the paper that no wall's light reaches, in radii of P9. [1]
float paper_radii(const DiscPicture& centre, const LandmarkGeometry& landmark) noexcept {
  return static_cast<float>(landmark.paper_radius_m() / landmark.centre_radius_m) -
         kPaperMargin_px / centre.semi_minor_px;
}

/// Every block on the paper, or every second one of both directions, and so on, where there are too many.
void collect(const Blocks& blocks, const std::array<DiscPicture, kDotCount>& discs, float radii,
             Samples& samples) noexcept {
  const DiscPicture& centre = discs[kCentreDot];
  const Eigen::Vector2f block_px(static_cast<float>(blocks.width_px()), static_cast<float>(blocks.height_px()));
  const Eigen::Vector2f middle = blocks.block_at(centre.centre_px);
  const Eigen::Vector2f half = radii * centre.px_per_radius.rowwise().norm().cwiseQuotient(block_px);
  const BlockRange range = blocks.around(middle, half);
  int step = 1;
  const int count = (range.x_end - range.x_begin) * (range.y_end - range.y_begin);
  while (count > static_cast<int>(kMostSamples) * step * step) ++step;
  for (int y = range.y_begin; y < range.y_end; y += step)
    for (int x = range.x_begin; x < range.x_end; x += step) {
      const Eigen::Vector2f from_middle_px =
          (Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - middle).cwiseProduct(block_px);
      const Eigen::Vector2f on_sheet = centre.radius_per_px * from_middle_px;
      if (on_sheet.squaredNorm() > radii * radii) continue;
      Sample sample;
      for (std::size_t dot = 0; dot < kDotCount; ++dot) {
        const DiscPicture& disc = discs[dot];
        const Eigen::Vector2f on_disc = disc.radius_per_px * (from_middle_px + centre.centre_px - disc.centre_px);
        sample.from[static_cast<Eigen::Index>(dot)] = disc.cover(disc.inside_px(on_disc), kBlockBlur_px);
      }
      sample.from.tail<3>() << 1, on_sheet / radii;
      sample.light = blocks.light_at(x, y);
      if (!samples.try_push_back(sample)) return;
    }
}

}  // namespace

std::array<InkFit, kDotCount> fit_sheet(const ImageView& luma, const ChromaView& chroma,
                                        const std::array<DiscPicture, kDotCount>& discs,
                                        const LandmarkGeometry& landmark) noexcept {
  EXPECTS(!chroma.empty());
  std::array<InkFit, kDotCount> fits;
  if (std::ranges::any_of(discs, [](const DiscPicture& disc) { return !(disc.semi_minor_px > 0); })) return fits;
  const float radii = paper_radii(discs[kCentreDot], landmark);
  if (!(radii > 0)) return fits;
  Samples samples;
  collect(Blocks(luma, chroma), discs, radii, samples);
  if (samples.size() <= kUnknowns) return fits;
  Normal normal = Normal::Zero();
  Solution products = Solution::Zero();
  for (const Sample& sample : samples) {
    normal.noalias() += sample.from * sample.from.transpose();
    products.noalias() += sample.from * sample.light.transpose();
  }
  normal.diagonal().head<kDotCount>().array() += kRidge;
  const Eigen::LDLT<Normal> ldlt(normal);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return fits;
  const Solution solution = ldlt.solve(products);
  const Normal covariance = ldlt.solve(Normal::Identity());
  const Eigen::Matrix3f paper = solution.bottomRows<3>().transpose();  // times (1, place) its light

  std::array<Eigen::Matrix3f, kDotCount> squares;
  squares.fill(Eigen::Matrix3f::Zero());
  Eigen::Array<float, kDotCount, 1> covers = decltype(covers)::Zero(), covers2 = covers;
  for (const Sample& sample : samples) {
    const Eigen::Vector3f off =
        (sample.light - solution.transpose() * sample.from).cwiseQuotient(paper * sample.from.tail<3>());
    const Eigen::Matrix3f square = off * off.transpose();
    covers += sample.from.head<kDotCount>().array(), covers2 += sample.from.head<kDotCount>().array().square();
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      squares[dot] += sample.from[static_cast<Eigen::Index>(dot)] * square;
  }
  const auto count = static_cast<float>(samples.size());
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    InkFit& fit = fits[dot];
    const auto at = static_cast<Eigen::Index>(dot);
    const Eigen::Vector2f place =
        discs[kCentreDot].radius_per_px * (discs[dot].centre_px - discs[kCentreDot].centre_px) / radii;
    fit.paper = paper * Eigen::Vector3f(1, place.x(), place.y());
    fit.drop_variance = covariance(at, at);
    if (!(fit.paper.minCoeff() >= kLeastPaper && kLeastSpread * fit.drop_variance <= 1)) continue;
    fit.drop = -solution.row(at).transpose().cwiseQuotient(fit.paper);
    fit.paper_variance = covariance(kPaper, kPaper);
    // So many whole samples say as much as those that the dot covers in part.
    const float whole = covers[at] / covers2[at];
    fit.freedoms = whole * covers[at] * (1 - kUnknowns / count);
    fit.residuals = whole * squares[dot];
    fit.usable = true;
  }
  return fits;
}

}  // namespace ninedot
