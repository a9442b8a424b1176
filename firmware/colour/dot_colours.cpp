// Each dot: light = paper + cover (ink - paper) by least squares, in blocks of pixels that are as coarse as the chroma.
// Beside P9, whose ink is the sheet's black, that gives the ink between black, 0, and paper, 1. What the pixels do not
// tell, the dots do together: how strong the ink appears at this size (blur, tone curve), and how noisy colour is.
#include "colour/dot_colours.h"

#include <algorithm>
#include <cmath>

#include "base/inline_vector.h"
#include "colour/disc_picture.h"
#include "colour/ink_fit.h"
#include "colour/ink_samples.h"
#include "colour/sheet_fit.h"

namespace ninedot {
namespace {

constexpr std::uint8_t kAllPlaces = 0xFF, kTwoOpposite = 0x11;  // bit k: place k

using RingFits = std::array<InkFit, kRingDotCount>;

// Paper around a dot: 3 px, or half of its radius where that is more; never nearer to the next dots than their blur.
constexpr float kMostBlocks = 48;         // of a disc: 30 samples, which make noise small beside what inks vary
constexpr float kMostBlocksWatched = 20;  // the least that tells ink from paper beside it, where the code is known
constexpr float kPaper_px = 3, kPaper_radii = 0.5F;
constexpr float kFarthestOfRing_radii = 2.4F;    // P9's outline is 4.3 radii from a ring dot's middle
constexpr float kFarthestOfCentre_radii = 1.8F;  // the ring's dots begin 2.65 radii of P9 from its middle
// Semi-minor axis below which dots have too little paper of their own: identified of 300 rendered views in even light,
// and of 300 with one dot hidden, one by one and together: 160 and 247, 99 and 210 at 2.7 px; 282 and 297, 231 and 251
// at 3.0 px; at 3.5 px 300 of both, and with a shadow's edge 298 and 259.
constexpr float kTogetherBelow_px = 1.4F;

InkSums sum_disc(const ImageView& luma, const ChromaView& chroma, const DiscPicture& disc,
                 const LandmarkGeometry& landmark, std::size_t dot, float most_blocks) noexcept {
  if (disc.semi_minor_px <= 0) return {};
  const double radius_m = landmark.radius_m(dot);
  PaperAround paper;
  paper.disc_radii = (landmark.centre_m(dot) / radius_m).cast<float>();
  paper.sheet_radii = static_cast<float>(landmark.paper_radius_m() / radius_m);
  paper.reach_radii = std::min(1 + std::max(kPaper_px / disc.semi_minor_px, kPaper_radii),
                               dot == kCentreDot ? kFarthestOfCentre_radii : kFarthestOfRing_radii);
  return sum_samples(luma, chroma, disc, paper, most_blocks);
}

// Black ink reflects 3 to 8 % of what paper does: where P9 cannot be read.
constexpr float kUsualDrop = 0.95F;
constexpr float kLeastDrop = 0.15F;  // fainter than that is no ink, or no P9
constexpr float kMostTint = 1.4F;    // of the black's colours against each other: else it is not black that is there

/// How much less light than paper the sheet's black sends, for red, green and blue.
Eigen::Vector3f black_drop(const InkFit& centre) noexcept {
  const Eigen::Vector3f usual = Eigen::Vector3f::Constant(kUsualDrop);
  if (!centre.usable || centre.drop.minCoeff() < kLeastDrop) return usual;
  if (centre.drop.maxCoeff() > kMostTint * centre.drop.minCoeff()) return usual;
  return centre.drop.cwiseMin(1.0F);
}

// The strongest of an ink's three drops, relative to black's: 1 for black, 0.92 to 0.98 for the inks of
// ink_classes.cpp.
constexpr float kStrongest = 0.97F;
constexpr float kLeastGain = 0.2F, kMostGain = 2;  // beyond: it is not these dots that are seen

/// How strong ink appears at the size of the ring's dots beside P9's: the median of their strongest drops, which up to
/// three hidden dots leave as it is. 0: no dot can be read.
float ring_gain(const RingFits& fits, const Eigen::Vector3f& black) noexcept {
  InlineVector<float, kRingDotCount> strongest;
  for (const InkFit& fit : fits)
    if (fit.usable) static_cast<void>(strongest.try_push_back(fit.drop.cwiseQuotient(black).maxCoeff()));
  if (strongest.empty()) return 0;
  float* middle = strongest.begin() + strongest.size() / 2;
  std::nth_element(strongest.begin(), middle, strongest.end());
  const float gain = *middle / kStrongest;
  return gain >= kLeastGain && gain <= kMostGain ? gain : 0;
}

constexpr float kPriorFreedoms = 10;  // the sheet's dots know the noise better than the few samples of one

/// Covariance of a sample about its fit, of the quieter half of the dots together, relative to the paper [1].
Eigen::Matrix3f quiet_covariance(const RingFits& fits) noexcept {
  InlineVector<float, kRingDotCount> loudness;
  for (const InkFit& fit : fits)
    if (fit.usable) static_cast<void>(loudness.try_push_back(fit.residuals.trace() / fit.freedoms));
  if (loudness.empty()) return Eigen::Matrix3f::Identity();
  float* middle = loudness.begin() + loudness.size() / 2;
  std::nth_element(loudness.begin(), middle, loudness.end());
  Eigen::Matrix3f sum = Eigen::Matrix3f::Zero();
  float freedoms = 0;
  for (const InkFit& fit : fits)
    if (fit.usable && fit.residuals.trace() / fit.freedoms <= *middle) sum += fit.residuals, freedoms += fit.freedoms;
  return sum / freedoms;
}

/// What the dots' paper together says of that around each: worth as many samples as its scatter among the dots, beyond
/// noise, permits, and no more than there are. A shadow's edge on the sheet leaves nothing of it.
PaperPrior common_paper(const RingFits& fits, const Eigen::Matrix3f& quiet) noexcept {
  PaperPrior prior;
  float dots = 0, samples = 0;
  for (const InkFit& fit : fits)
    if (fit.usable) prior.light += fit.paper, dots += 1, samples += fit.freedoms;
  if (dots < 2) return {};
  prior.light /= dots;
  const float sample_variance = quiet.trace() / 3;
  float scatter = 0;
  for (const InkFit& fit : fits)
    if (fit.usable)
      scatter +=
          (fit.paper - prior.light).cwiseQuotient(prior.light).squaredNorm() / 3 - sample_variance * fit.paper_variance;
  scatter /= dots - 1;
  prior.samples = sample_variance / std::max(scatter, sample_variance / samples);
  return prior;
}

/// Variance of a sample's light by the luma's noise alone, relative to the paper: of (grey / 255)^2, four pixels.
float luma_variance(const InkFit& fit, const PictureNoise& noise) noexcept {
  const float grey = std::sqrt(std::min(fit.paper.y(), 1.0F));
  const auto sigma = static_cast<float>(noise.at(255.0 * static_cast<double>(grey)) / 255);
  return sigma * sigma / (grey * grey);
}

/// What a sheet is printed with, and how noisy colour is there.
struct SheetInks {
  RingFits ring;
  InkFit centre;
  Eigen::Matrix3f quiet = Eigen::Matrix3f::Identity();
};

SheetInks inks_together(const ImageView& luma, const ChromaView& chroma,
                        const std::array<DiscPicture, kDotCount>& discs, const LandmarkGeometry& landmark,
                        const Eigen::Vector2f& line_px) noexcept {
  const std::array<InkFit, kDotCount> fits = fit_sheet(luma, chroma, discs, landmark, line_px);
  SheetInks inks;
  std::copy_n(fits.begin(), kRingDotCount, inks.ring.begin());
  inks.centre = fits[kCentreDot];
  inks.quiet = quiet_covariance(inks.ring);
  return inks;
}

/// \param places  bit k: look at place k
SheetInks inks_one_by_one(const ImageView& luma, const ChromaView& chroma,
                          const std::array<DiscPicture, kDotCount>& discs, const LandmarkGeometry& landmark,
                          std::uint8_t places, float most_blocks) noexcept {
  const auto sums_of = [&](std::size_t dot) { return sum_disc(luma, chroma, discs[dot], landmark, dot, most_blocks); };
  SheetInks inks;
  std::array<InkSums, kRingDotCount> sums;
  for (std::size_t place = 0; place < kRingDotCount; ++place) {
    if (((places >> place) & 1U) == 0) continue;
    sums[place] = sums_of(place);
    inks.ring[place] = fit_ink(sums[place]);
  }
  inks.quiet = quiet_covariance(inks.ring);
  const PaperPrior paper = common_paper(inks.ring, inks.quiet);
  for (std::size_t place = 0; place < kRingDotCount; ++place)
    if (inks.ring[place].usable) inks.ring[place] = fit_ink(sums[place], paper);
  inks.centre = fit_ink(sums_of(kCentreDot));
  return inks;
}

// No single dot may outvote all others, whatever the model says: 1 to 10,000.
constexpr float kLeastLikelihood = 1e-4F;

MeasuredInk ink_of(const InkFit& fit, const Eigen::Vector3f& black, float gain, const Eigen::Matrix3f& quiet,
                   const PictureNoise& noise) noexcept {
  const Eigen::Vector3f per_drop = (black * gain).cwiseInverse();
  Eigen::Matrix3f sample = (kPriorFreedoms * quiet + fit.residuals) / (kPriorFreedoms + fit.freedoms);
  sample.diagonal().array() += luma_variance(fit, noise);
  MeasuredInk ink;
  ink.whiteness = Eigen::Vector3f::Ones() - fit.drop.cwiseProduct(per_drop);
  ink.covariance = fit.drop_variance * (per_drop.asDiagonal() * sample * per_drop.asDiagonal());
  // Light that changes around the dot moves all three colours together; that is no noise that a mean would take out.
  ink.shade = std::sqrt(std::max(0.0F, (fit.residuals / fit.freedoms - quiet).sum() / 9));
  ink.black_reflectance = 1 - std::min(black.mean(), 1.0F);
  return ink;
}

}  // namespace

DotColours ColourReader::read(const ImageView& luma, const ChromaView& chroma,
                              const CameraFromLandmark& T_camera_landmark, const PictureNoise& noise,
                              const PictureMotion& motion) const noexcept {
  return read_places(luma, chroma, T_camera_landmark, noise, motion, kAllPlaces, kMostBlocks);
}

DotColours ColourReader::watch(const ImageView& luma, const ChromaView& chroma,
                               const CameraFromLandmark& T_camera_landmark, const PictureNoise& noise,
                               std::uint64_t frame_number, const PictureMotion& motion) const noexcept {
  const auto places = static_cast<std::uint8_t>(kTwoOpposite << (frame_number % (kRingDotCount / 2)));
  return read_places(luma, chroma, T_camera_landmark, noise, motion, places, kMostBlocksWatched);
}

DotColours ColourReader::read_places(const ImageView& luma, const ChromaView& chroma,
                                     const CameraFromLandmark& T_camera_landmark, const PictureNoise& noise,
                                     const PictureMotion& motion, std::uint8_t places,
                                     float most_blocks) const noexcept {
  DotColours colours;
  if (luma.empty() || chroma.empty()) return colours;
  std::array<DiscPicture, kDotCount> discs;
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    discs[dot] = disc_in_picture(T_camera_landmark, camera_, landmark_.centre_m(dot), landmark_.radius_m(dot));
  const Eigen::Vector2f middle_px = discs[kCentreDot].centre_px;
  for (DiscPicture& disc : discs) disc.centre_px += (disc.centre_px.y() - middle_px.y()) * motion.per_row_px;
  const bool draws_lines = motion.line_px.norm() > 2 * discs[0].semi_minor_px;
  const SheetInks inks =
      discs[0].semi_minor_px < kTogetherBelow_px || draws_lines
          ? inks_together(luma, chroma, discs, landmark_, draws_lines ? motion.line_px : Eigen::Vector2f::Zero())
          : inks_one_by_one(luma, chroma, discs, landmark_, places, most_blocks);
  const Eigen::Vector3f black = black_drop(inks.centre);
  const float gain = ring_gain(inks.ring, black);
  if (gain <= 0) return colours;
  for (std::size_t place = 0; place < kRingDotCount; ++place) {
    if (!inks.ring[place].usable) continue;
    const InkLikelihoods likelihoods = ink_likelihoods(ink_of(inks.ring[place], black, gain, inks.quiet, noise));
    const float most = *std::ranges::max_element(likelihoods.letters);
    if (!(most > 0)) continue;
    const auto log_of = [&](float likelihood) { return std::log(std::max(likelihood / most, kLeastLikelihood)); };
    std::ranges::transform(likelihoods.letters, colours.log_likelihood[place].begin(), log_of);
    colours.log_colourless[place] = log_of(likelihoods.colourless);
    colours.has_colour = true;
  }
  return colours;
}

char DotColours::letter(std::size_t place) const noexcept {
  const auto& row = log_likelihood[place];
  const auto best = static_cast<std::size_t>(std::ranges::max_element(row) - row.begin());
  for (std::size_t other = 0; other < row.size(); ++other)
    if (other != best && row[other] > row[best] - std::log(20.0F)) return '?';
  return kInkLetters[best];
}

}  // namespace ninedot
