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

/// Of sum (cover - what the others have of it)^2. Below, where a dot lies on the sensor's pattern says more than its
/// ink: of rendered rings of 2.0 and 2.2 px 4 of 190 were named wrongly down to 0.03, none of 155 with this. [1]
constexpr float kLeastSpread = 0.06F;
constexpr float kRidge = 1e-3F;  // a dot that no block sees has a step of no size, and no certainty
// The sheet of dots of 2 px in radius has 190 blocks, and of larger ones a part; lines of 15 px need as many again.
template <int kBeyond>
constexpr std::size_t kMostSamples = kBeyond == 0 ? 256 : 512;

// A line is drawn in steps that are as short as what a block sees is wide, sixteen at most.
constexpr float kStep_px = 1.5F;
constexpr int kMostSteps = 16;
constexpr float kLeastPaperShare =
    0.25F;                       // of what a block sees, what lies beyond the sheet being one light at each end
constexpr float kWhole = 0.98F;  // at some time it sees nothing but the sheet, else a third side is near

/// A block of pixels: what it gets its light from, and its light. The dots' steps from paper to ink, the paper, its
/// slope in both directions; then, where motion draws lines, what lies beyond the sheet at their beginnings and ends.
template <int kBeyond>
struct Sample {
  static constexpr int kPaper = kDotCount, kFirstBeyond = kPaper + 3, kUnknowns = kFirstBeyond + kBeyond;
  Eigen::Matrix<float, kUnknowns, 1> from;
  Eigen::Vector3f light;

  /// The paper's own, as if nothing lay beyond it.
  Eigen::Vector3f paper_and_slope() const noexcept {
    if constexpr (kBeyond == 0) return from.template segment<3>(kPaper);
    return from.template segment<3>(kPaper) / from[kPaper];
  }
};
template <int kBeyond>
using Samples = InlineVector<Sample<kBeyond>, kMostSamples<kBeyond>>;

/// Radius of the paper that no wall's light reaches, in radii of P9. [1]
float paper_radii(const DiscPicture& centre, const LandmarkGeometry& landmark) noexcept {
  return static_cast<float>(landmark.paper_radius_m() / landmark.centre_radius_m) -
         kPaperMargin_px / centre.semi_minor_px;
}

/// Calls at(place) at even steps along a line about the origin. \return  how many
template <typename At>
int along_line(const Eigen::Vector2f& line_px, At&& at) noexcept {
  const int steps = std::clamp(static_cast<int>(std::ceil(line_px.norm() / kStep_px)), 1, kMostSteps);
  for (int i = 0; i < steps; ++i) at(((static_cast<float>(i) + 0.5F) / static_cast<float>(steps) - 0.5F) * line_px);
  return steps;
}

/// The share of a block that is sheet, what lies beyond at the lines' ends, and the most of it that is sheet at a time.
struct PaperShares {
  float paper = 0, at_begin = 0, at_end = 0, most = 0;
};
PaperShares paper_shares(const DiscPicture& centre, float side_radii, const Eigen::Vector2f& from_middle_px,
                         const Eigen::Vector2f& line_px) noexcept {
  PaperShares shares;
  const int steps = along_line(line_px, [&](const Eigen::Vector2f& by_px) {
    const Eigen::Vector2f at_px = from_middle_px - by_px;
    const Eigen::Array2f inside_px =
        centre.semi_minor_px * (side_radii - (centre.radius_per_px * at_px).array().abs()) / kBlockBlur_px;
    const float paper = DiscPicture::normal_step(inside_px.x()) * DiscPicture::normal_step(inside_px.y());
    shares.paper += paper, shares.most = std::max(shares.most, paper);
    (at_px.dot(line_px) > 0 ? shares.at_end : shares.at_begin) += 1 - paper;
  });
  const auto count = static_cast<float>(steps);
  shares.paper /= count, shares.at_begin /= count, shares.at_end /= count;
  return shares;
}

/// Every block on the paper, or every second one of both directions, and so on, where there are too many.
/// \param radii  paper_radii()
template <int kBeyond>
void collect(const Blocks& blocks, const std::array<DiscPicture, kDotCount>& discs, float radii, float side_radii,
             const Eigen::Vector2f& line_px, Samples<kBeyond>& samples) noexcept {
  const DiscPicture& centre = discs[kCentreDot];
  const Eigen::Vector2f block_px(static_cast<float>(blocks.width_px()), static_cast<float>(blocks.height_px()));
  const Eigen::Vector2f middle = blocks.block_at(centre.centre_px);
  Eigen::Vector2f half_px = radii * centre.px_per_radius.rowwise().norm();
  if constexpr (kBeyond > 0)
    half_px = side_radii * centre.px_per_radius.rowwise().lpNorm<1>() + 0.5F * line_px.cwiseAbs();
  const BlockRange range = blocks.around(middle, half_px.cwiseQuotient(block_px));
  int step = 1;
  const int count = (range.x_end - range.x_begin) * (range.y_end - range.y_begin);
  while (count > static_cast<int>(kMostSamples<kBeyond>) * step * step) ++step;
  for (int y = range.y_begin; y < range.y_end; y += step)
    for (int x = range.x_begin; x < range.x_end; x += step) {
      const Eigen::Vector2f from_middle_px =
          (Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - middle).cwiseProduct(block_px);
      const Eigen::Vector2f on_sheet = centre.radius_per_px * from_middle_px;
      Sample<kBeyond> sample;
      sample.from.template segment<3>(Sample<kBeyond>::kPaper) << 1, on_sheet / radii;
      if constexpr (kBeyond == 0) {
        if (on_sheet.squaredNorm() > radii * radii) continue;
      } else {
        const PaperShares shares = paper_shares(centre, side_radii, from_middle_px, line_px);
        if (!(shares.paper >= kLeastPaperShare && shares.most >= kWhole)) continue;
        sample.from.template segment<3>(Sample<kBeyond>::kPaper) *= shares.paper;
        sample.from.template tail<kBeyond>() << shares.at_begin, shares.at_end;
      }
      for (std::size_t dot = 0; dot < kDotCount; ++dot) {
        const DiscPicture& disc = discs[dot];
        const Eigen::Vector2f from_disc_px = from_middle_px + centre.centre_px - disc.centre_px;
        float cover = 0;
        const int steps = along_line(line_px, [&](const Eigen::Vector2f& by_px) {
          cover += disc.cover(disc.inside_px(disc.radius_per_px * (from_disc_px - by_px)), kBlockBlur_px);
        });
        sample.from[static_cast<Eigen::Index>(dot)] = cover / static_cast<float>(steps);
      }
      sample.light = blocks.light_at(x, y);
      if (!samples.try_push_back(sample)) return;
    }
}

template <int kBeyond>
std::array<InkFit, kDotCount> fit(const Blocks& blocks, const std::array<DiscPicture, kDotCount>& discs,
                                  const LandmarkGeometry& landmark, const Eigen::Vector2f& line_px) noexcept {
  using OneSample = Sample<kBeyond>;
  constexpr int kUnknowns = OneSample::kUnknowns, kPaper = OneSample::kPaper;
  using Normal = Eigen::Matrix<float, kUnknowns, kUnknowns>;
  using Solution = Eigen::Matrix<float, kUnknowns, 3>;  // of red, green and blue
  std::array<InkFit, kDotCount> fits;
  const float radii = paper_radii(discs[kCentreDot], landmark);
  if (!(radii > 0)) return fits;
  const auto side_radii = static_cast<float>(landmark.paper_radius_m() / landmark.centre_radius_m);
  Samples<kBeyond> samples;
  collect<kBeyond>(blocks, discs, radii, side_radii, line_px, samples);
  if (samples.size() <= kUnknowns) return fits;
  Normal normal = Normal::Zero();
  Solution products = Solution::Zero();
  for (const OneSample& sample : samples) {
    normal.noalias() += sample.from * sample.from.transpose();
    products.noalias() += sample.from * sample.light.transpose();
  }
  normal.diagonal().template head<kDotCount>().array() += kRidge;
  normal.diagonal().template tail<kBeyond>().array() += kRidge;
  const Eigen::LDLT<Normal> ldlt(normal);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0)) return fits;
  const Solution solution = ldlt.solve(products);
  const Normal covariance = ldlt.solve(Normal::Identity());
  const Eigen::Matrix3f paper = solution.template middleRows<3>(kPaper).transpose();  // times (1, place) its light

  std::array<Eigen::Matrix3f, kDotCount> squares;
  squares.fill(Eigen::Matrix3f::Zero());
  Eigen::Array<float, kDotCount, 1> covers = decltype(covers)::Zero(), covers2 = covers;
  for (const OneSample& sample : samples) {
    const Eigen::Vector3f off =
        (sample.light - solution.transpose() * sample.from).cwiseQuotient(paper * sample.paper_and_slope());
    const Eigen::Matrix3f square = off * off.transpose();
    const auto cover = sample.from.template head<kDotCount>().array();
    covers += cover, covers2 += cover.square();
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      squares[dot] += sample.from[static_cast<Eigen::Index>(dot)] * square;
  }
  const auto count = static_cast<float>(samples.size());
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    InkFit& of_dot = fits[dot];
    const auto at = static_cast<Eigen::Index>(dot);
    const Eigen::Vector2f place =
        discs[kCentreDot].radius_per_px * (discs[dot].centre_px - discs[kCentreDot].centre_px) / radii;
    of_dot.paper = paper * Eigen::Vector3f(1, place.x(), place.y());
    of_dot.drop_variance = covariance(at, at);
    if (!(of_dot.paper.minCoeff() >= kLeastPaper && kLeastSpread * of_dot.drop_variance <= 1)) continue;
    of_dot.drop = -solution.row(at).transpose().cwiseQuotient(of_dot.paper);
    of_dot.paper_variance = covariance(kPaper, kPaper);
    // So many whole samples say as much as those that the dot covers in part.
    const float whole = covers[at] / covers2[at];
    of_dot.freedoms = whole * covers[at] * (1 - kUnknowns / count);
    of_dot.residuals = whole * squares[dot];
    of_dot.usable = true;
  }
  return fits;
}

}  // namespace

std::array<InkFit, kDotCount> fit_sheet(const ImageView& luma, const ChromaView& chroma,
                                        const std::array<DiscPicture, kDotCount>& discs,
                                        const LandmarkGeometry& landmark, const Eigen::Vector2f& line_px) noexcept {
  EXPECTS(!chroma.empty());
  if (std::ranges::any_of(discs, [](const DiscPicture& disc) { return !(disc.semi_minor_px > 0); })) return {};
  const Blocks blocks(luma, chroma);
  return line_px.isZero(0) ? fit<0>(blocks, discs, landmark, line_px) : fit<2>(blocks, discs, landmark, line_px);
}

}  // namespace ninedot
