#include "colour/ink_fit.h"

namespace ninedot {
namespace {

constexpr float kLeastSamples = 4;  // two are fitted
// Of sum (cover - its mean)^2: half of one block. A dot of 1.6 px in front has it.
constexpr float kLeastSpread = 0.1F;

}  // namespace

InkFit fit_ink(const InkSums& sums, const PaperPrior& prior) noexcept {
  InkFit fit;
  if (sums.count < kLeastSamples) return fit;
  const float count = sums.count + prior.samples;
  const Eigen::Vector3f light = sums.light + prior.samples * prior.light;
  const float spread = sums.cover2 - sums.cover * sums.cover / count;
  if (spread < kLeastSpread) return fit;
  const Eigen::Vector3f step = (sums.covered_light - light * (sums.cover / count)) / spread;  // ink - paper
  fit.paper = (light - step * sums.cover) / count;
  if (fit.paper.minCoeff() < kLeastPaper) return fit;
  const Eigen::Vector3f per_paper = fit.paper.cwiseInverse();
  fit.drop = -step.cwiseProduct(per_paper);
  fit.paper_variance = sums.cover2 / (count * spread);
  fit.drop_variance = 1 / spread;
  fit.freedoms = sums.count - 2;
  // Sum (v - p - c s)(v - p - c s)^T, multiplied out.
  const Eigen::Matrix3f light_paper = sums.light * fit.paper.transpose();
  const Eigen::Matrix3f covered_step = sums.covered_light * step.transpose();
  const Eigen::Matrix3f paper_step = fit.paper * step.transpose();
  const Eigen::Matrix3f residuals = sums.light2 - light_paper - light_paper.transpose() - covered_step -
                                    covered_step.transpose() + sums.count * (fit.paper * fit.paper.transpose()) +
                                    sums.cover * (paper_step + paper_step.transpose()) +
                                    sums.cover2 * (step * step.transpose());
  fit.residuals = per_paper.asDiagonal() * residuals * per_paper.asDiagonal();
  fit.residuals.diagonal() = fit.residuals.diagonal().cwiseMax(0.0F);  // the last bits of large sums
  fit.usable = true;
  return fit;
}

}  // namespace ninedot
