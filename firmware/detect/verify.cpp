#include "detect/verify.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "detect/homography.h"

// Light changes across the sheet and shadows cut through it, so brightness is only ever compared with brightness close
// by: outside against inside of one outline, in one direction. A shadow scales both by the same factor.

namespace ninedot {
namespace {

constexpr int kDirections = 16;        // of each outline: two for each dot of the ring, and one in between
constexpr double kBeside_px = 1.2;     // from an outline: its blur (sigma 0.6 px) is over at two sigma
constexpr double kBesideShare = 0.25;  // of the radius, where that is more: what a guessed outline may be off by
constexpr double kMinContrast_lsb =
    5;  // half of what a blob needs (blob_finder.cpp): the outline of a small dot is pale
constexpr double kContrastPerNoise = 3;  // below, sixteen directions in which it is brighter outside are no evidence
constexpr double kMinShare = 0.35;       // of the landmark's typical contrast, scaled by the local light
constexpr double kLeastLight = 0.3, kMostLight = 1.5;  // beyond these paper is not lit differently but another thing
constexpr float kFlawless = 1;
constexpr float kPartly = 5.0F / kDirections;  // a dot that something hides in part
// Three dots, two halves beside them and half of P9, which counts twice: half a sheet, 3 + 1 + 1, less a direction or
// two.
constexpr double kMinScoreOfThree = 4.9;
constexpr double kMinPaper = 0.75;    // of the samples between the dots: a shadow's edge or a stain may spoil a quarter
constexpr double kBlankShare = 0.25;  // of the expected contrast: less between both sides of an outline is none
constexpr double kDarkPaperShare = 0.4;  // of the typical contrast: paper darker by this is something else
constexpr double kSamePaperShare =
    0.15;                        // likewise: what is no darker than this is the sheet itself, in the same light
constexpr double kOnADot = 0.7;  // of a dot's radius around its middle: two blobs so close are one dot

using Directions = std::array<Eigen::Vector2d, kDirections>;

Directions make_directions() noexcept {
  Directions directions;
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const double a_rad = static_cast<double>(d) * 2 * std::numbers::pi / kDirections;
    directions[d] = {std::cos(a_rad), std::sin(a_rad)};
  }
  return directions;
}
const Directions kDirection = make_directions();

struct Sides {
  bool inside_picture = false;
  double out = 0, in = 0;
};

std::optional<double> sample(const ImageView& luma, const Eigen::Vector2d& px) noexcept {
  // Left of the picture's last column and above its last row; what is not a number is nowhere.
  if (!(px.x() >= 0 && px.y() >= 0 && px.x() < luma.width_px - 1 && px.y() < luma.height_px - 1)) return std::nullopt;
  const auto ix = static_cast<int>(px.x()), iy = static_cast<int>(px.y());
  const double fx = px.x() - ix, fy = px.y() - iy;
  return (1 - fy) * ((1 - fx) * luma.at(ix, iy) + fx * luma.at(ix + 1, iy)) +
         fy * ((1 - fx) * luma.at(ix, iy + 1) + fx * luma.at(ix + 1, iy + 1));
}

class Evidence {
 public:
  Evidence(const ImageView& luma, const Eigen::Matrix3d& H, const LandmarkGeometry& landmark,
           const Hypothesis& hypothesis, double noise_lsb) noexcept
      : luma_(luma), landmark_(landmark), hypothesis_(hypothesis), H_(H), noise_lsb_(noise_lsb) {
    for (std::size_t dot = 0; dot < kDotCount; ++dot) look_at_outline(dot);
    find_typical_contrast();
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      inside_lsb_[dot] = mean_inside(dot);
      visible_[dot] = visible_fraction(dot);
    }
  }

  Verification judge(const BlobList& blobs) const noexcept {
    Verification v;
    v.contrast_lsb = typical_lsb_;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      v.visible_fraction[dot] = visible_[dot];
      v.score += v.visible_fraction[dot] * (dot == kCentreDot ? 2 : 1);
    }
    const auto ring_dots_from = [&](float least) {
      return static_cast<int>(std::count_if(v.visible_fraction.begin(), v.visible_fraction.begin() + kRingDotCount,
                                            [=](float fraction) { return fraction >= least; }));
    };
    const int whole = ring_dots_from(kSeenOutline), flawless = ring_dots_from(kFlawless);
    const int partly = ring_dots_from(kPartly) - whole;
    const float centre = v.visible_fraction[kCentreDot];
    const int seen = whole + (centre >= kSeenOutline ? 1 : 0);
    // Three points fit any three dots of equal size: then everything else must be flawless.
    const bool enough = (hypothesis_.matched > 3 || (flawless >= 3 && v.score >= kMinScoreOfThree)) &&
                        ((centre >= kSeenOutline && whole >= 3) ||
                         (centre >= kPartly && whole >= 3 && whole + partly >= 4) || whole >= 5);
    if (enough)
      v.refusal = refusal_of_whole(v, blobs, seen);
    else if (flawless >= 3)
      v.has_three_dots = refusal_of_whole(v, blobs, seen) == Refusal::kNone;
    return v;
  }

 private:
  /// Where there are outlines enough: the cheapest to ask comes first.
  Refusal refusal_of_whole(const Verification& v, const BlobList& blobs, int seen) const noexcept {
    if (typical_lsb_ < std::max(kMinContrast_lsb, kContrastPerNoise * noise_lsb_)) return Refusal::kFaint;
    if (!paper_is_blank()) return Refusal::kDarkBetween;
    if (centre_is_absent(v.visible_fraction[kCentreDot])) return Refusal::kNoCentre;
    return are_hidden_not_absent(v, blobs, seen) ? Refusal::kNone : Refusal::kOtherPattern;
  }

  Eigen::Vector2d plane_point(std::size_t dot, int direction, double radius_m) const noexcept {
    return landmark_.centre_m(dot) + radius_m * kDirection[static_cast<std::size_t>(direction)];
  }

  /// Both sides of the outline, 1.2 px or a quarter of the radius away from it, whatever is more.
  void look_at_outline(std::size_t dot) noexcept {
    const Eigen::Matrix2d J = jacobian_of_map(H_, landmark_.centre_m(dot));
    const double radius_m = landmark_.radius_m(dot);
    for (int d = 0; d < kDirections; ++d) {
      const double px_per_m = (J * kDirection[static_cast<std::size_t>(d)]).norm();
      const double step_m = std::max(kBeside_px / px_per_m, kBesideShare * radius_m);
      const auto out = sample(luma_, map_point(H_, plane_point(dot, d, radius_m + step_m)));
      const auto in = sample(luma_, map_point(H_, plane_point(dot, d, std::max(radius_m - step_m, 0.0))));
      if (out && in) sides_[dot][static_cast<std::size_t>(d)] = {true, *out, *in};
    }
  }

  void find_typical_contrast() noexcept {
    InlineVector<double, kDotCount * kDirections> contrasts, papers;
    for (const auto& dot : sides_) {
      for (const Sides& s : dot) {
        if (!s.inside_picture || s.out - s.in < kMinContrast_lsb) continue;
        (void)contrasts.try_push_back(s.out - s.in);
        (void)papers.try_push_back(s.out);
      }
    }
    if (contrasts.empty()) return;
    const auto middle = static_cast<std::ptrdiff_t>(contrasts.size() / 2);
    std::nth_element(contrasts.begin(), contrasts.begin() + middle, contrasts.end());
    std::nth_element(papers.begin(), papers.begin() + middle, papers.end());
    typical_lsb_ = contrasts[static_cast<std::size_t>(middle)];
    paper_lsb_ = papers[static_cast<std::size_t>(middle)];
  }

  /// The contrast that an outline must show where its paper has this brightness.
  double expected_lsb(double paper_lsb) const noexcept {
    return typical_lsb_ * std::clamp(paper_lsb / std::max(paper_lsb_, 1.0), kLeastLight, kMostLight);
  }

  bool is_edge(const Sides& s) const noexcept {
    return s.inside_picture && s.out - s.in > std::max(kMinContrast_lsb, kMinShare * expected_lsb(s.out));
  }

  /// A dot is ink from its outline to its middle: a washer or a hole with a rim is none.
  bool is_hollow(std::size_t dot) const noexcept {
    const auto middle = sample(luma_, map_point(H_, landmark_.centre_m(dot)));
    return middle && *middle - inside_lsb_[dot] > kMinShare * expected_lsb(paper_lsb_);
  }

  float visible_fraction(std::size_t dot) const noexcept {
    if (is_hollow(dot)) return 0;
    const auto edges =
        std::count_if(sides_[dot].begin(), sides_[dot].end(), [this](const Sides& s) { return is_edge(s); });
    return static_cast<float>(edges) / kDirections;
  }

  double mean_inside(std::size_t dot) const noexcept {
    double sum = 0;
    int count = 0;
    for (const Sides& s : sides_[dot])
      if (s.inside_picture) sum += s.in, ++count;
    return count > 0 ? sum / count : 0;
  }

  /// Between P9 and the ring, and between neighbours of the ring, there is paper: brighter than the dots on either
  /// side.
  bool paper_is_blank() const noexcept {
    int asked = 0, blank = 0;
    const auto ask = [&](const Eigen::Vector2d& plane_m, double ink_lsb) {
      const auto paper = sample(luma_, map_point(H_, plane_m));
      if (!paper) return;
      ++asked;
      if (*paper - ink_lsb > kMinShare * expected_lsb(*paper)) ++blank;
    };
    const double between_m = 0.5 * (landmark_.centre_radius_m + landmark_.ring_radius_m - landmark_.dot_radius_m);
    for (int d = 0; d < kDirections; ++d) {
      const Sides& s = sides_[kCentreDot][static_cast<std::size_t>(d)];
      if (is_edge(s)) ask(plane_point(kCentreDot, d, between_m), s.in);
    }
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
      const std::size_t next = (dot + 1) % kRingDotCount;
      if (visible_[dot] < kSeenOutline || visible_[next] < kSeenOutline) continue;
      ask((landmark_.centre_m(dot) + landmark_.centre_m(next)) / 2, std::max(inside_lsb_[dot], inside_lsb_[next]));
    }
    return asked == 0 || blank >= kMinPaper * asked;
  }

  /// Blank paper where a dot should be: as bright inside as outside, all around.
  /// \param dark_share  how much darker than the sheet's paper it may be, of the typical contrast
  bool is_blank(std::size_t dot, double dark_share) const noexcept {
    int asked = 0, blank = 0;
    for (const Sides& s : sides_[dot]) {
      if (!s.inside_picture) continue;
      ++asked;
      if (std::abs(s.out - s.in) < kBlankShare * expected_lsb(s.out) && s.in > paper_lsb_ - dark_share * typical_lsb_)
        ++blank;
    }
    return asked > kDirections / 2 && blank > 0.8 * asked;
  }

  bool centre_is_absent(float centre_fraction) const noexcept {
    if (centre_fraction >= kSeenOutline) return false;
    if (is_blank(kCentreDot, kDarkPaperShare)) return true;
    // What hides P9's outline in one direction and comes from outside hides the ring's dot in that direction too. Up to
    // half of the sheet hidden this holds for a straight edge; a little beyond, two directions may break it.
    int contradictions = 0;
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
      const Eigen::Vector2d towards = landmark_.centre_m(dot);
      const double a_rad = std::atan2(towards.y(), towards.x());
      const auto d = static_cast<std::size_t>(
          (static_cast<int>(std::lround(a_rad * kDirections / (2 * std::numbers::pi))) + kDirections) % kDirections);
      const Sides& beside = sides_[kCentreDot][d];
      if (visible_[dot] >= kSeenOutline && beside.inside_picture && !is_edge(beside)) ++contradictions;
    }
    return contradictions >= 3;
  }

  /// Stands out from all around by as much, in proportion to the light, as ink does: not a stain on something that
  /// hides the sheet.
  bool is_ink_on_paper(const Eigen::Vector2d& plane_m) const noexcept {
    constexpr double kLikeInk = 0.75;  // of the typical contrast: a stain has half of ink's
    constexpr int kAround = 8;         // two of them may lie on the next dot's blur
    const auto middle = sample(luma_, map_point(H_, plane_m));
    if (!middle) return false;
    int standing_out = 0;
    for (int d = 0; d < kAround; ++d) {
      const double a_rad = d * 2 * std::numbers::pi / kAround;
      const Eigen::Vector2d off = 1.7 * landmark_.dot_radius_m * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad));
      const auto around = sample(luma_, map_point(H_, plane_m + off));
      if (around && (*around - *middle) * paper_lsb_ > kLikeInk * typical_lsb_ * *around) ++standing_out;
    }
    return standing_out >= kAround - 2;
  }

  /// What a dot of the ring covers there, seen as the guess has it.
  double ring_dot_area_px2(const Eigen::Vector2d& plane_m) const noexcept {
    return std::numbers::pi * landmark_.dot_radius_m * landmark_.dot_radius_m *
           jacobian_of_map(hypothesis_.H_px_plane, plane_m).determinant();
  }

  /// Is the blob of this index a dot's?
  bool is_matched(std::size_t i) const noexcept {
    return std::find(hypothesis_.blob.begin(), hypothesis_.blob.end(), static_cast<int>(i)) != hypothesis_.blob.end();
  }

  /// Ink with paper all around that no dot accounts for.
  struct Unmatched {
    int strangers = 0;                             ///< of about a ring dot's size, within the sheet's dotted part
    std::array<bool, kRingDotCount> is_beside{};   ///< a whole dot, beside the place of this one
    std::array<bool, kRingDotCount> is_resized{};  ///< in the place of this one, and much smaller or larger
  };

  Unmatched unmatched_ink(const BlobList& blobs) const noexcept {
    // Of a dot's radius around its middle. Nearer than half of it a warped sheet has its dots too; further away than
    // one the dot leaves its place to paper, which the outlines tell.
    constexpr double kInPlace = 0.5, kOverlapping = 1;
    constexpr double kLeastWhole = 0.75, kMostWhole = 1.4;  // of a ring dot's area: what hides a dot leaves less of it
    constexpr double kLeastStrange = 0.4, kMostStrange = 2.5;
    constexpr double kMuchSmaller = 0.6, kMuchLarger = 1.7, kSpeck = 0.1, kBlotch = 4;
    const double reach_m = landmark_.ring_radius_m + landmark_.dot_radius_m;
    const Eigen::Matrix3d plane_from_px = hypothesis_.H_px_plane.inverse();
    Unmatched found;
    for (std::size_t i = 0; i < blobs.size(); ++i) {
      const Eigen::Vector2d plane_m = map_point(plane_from_px, Eigen::Vector2d(blobs[i].x_px, blobs[i].y_px));
      if (!(plane_m.norm() < reach_m)) continue;
      const double area = blobs[i].area_px2 / ring_dot_area_px2(plane_m);
      if (area < kSpeck || area > kBlotch || is_matched(i) || !is_ink_on_paper(plane_m)) continue;
      const bool is_strange = area >= kLeastStrange && area <= kMostStrange;
      if (is_strange && !is_on_a_dot(plane_m)) ++found.strangers;
      for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
        const double off = (plane_m - landmark_.centre_m(dot)).norm() / landmark_.dot_radius_m;
        found.is_beside[dot] |= off > kInPlace && off < kOverlapping && area > kLeastWhole && area < kMostWhole;
        found.is_resized[dot] |= off < kInPlace && (area < kMuchSmaller || area > kMuchLarger);
      }
    }
    return found;
  }

  /// The same dot found a second time, or a part of it, is no intruder.
  bool is_on_a_dot(const Eigen::Vector2d& plane_m) const noexcept {
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      if (visible_[dot] >= kPartly && (plane_m - landmark_.centre_m(dot)).norm() < kOnADot * landmark_.radius_m(dot))
        return true;
    return false;
  }

  /// Hidden dots come in a row. A hole between two whole dots is dirt once, unless the sheet itself is in its place or
  /// its dot is somewhere else; and another pattern twice. Dots of other sizes are cut by an edge once or twice, and
  /// another pattern where there are more.
  bool are_hidden_not_absent(const Verification& v, const BlobList& blobs, int seen) const noexcept {
    constexpr int kMostResized = 2;
    const Unmatched unmatched = unmatched_ink(blobs);
    int holes = 0, resized = 0;
    bool is_absent = false;
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
      if (v.visible_fraction[dot] >= kSeenOutline) continue;
      if (unmatched.is_resized[dot]) ++resized;
      const float before = v.visible_fraction[(dot + 7) % 8], after = v.visible_fraction[(dot + 1) % 8];
      if (before < kSeenOutline || after < kSeenOutline) continue;
      is_absent = is_absent || unmatched.is_beside[dot] || is_blank(dot, kSamePaperShare);
      if (v.visible_fraction[dot] < kSeenOutline / 2) ++holes;
    }
    const int strangers = unmatched.strangers;
    return holes <= 1 && !is_absent && resized <= kMostResized && (holes == 0 || strangers == 0) &&
           2 * strangers <= seen - 3;
  }

  const ImageView& luma_;
  const LandmarkGeometry& landmark_;
  const Hypothesis& hypothesis_;
  const Eigen::Matrix3d& H_;
  double noise_lsb_;
  double typical_lsb_ = 0, paper_lsb_ = 0;
  std::array<std::array<Sides, kDirections>, kDotCount> sides_{};
  std::array<double, kDotCount> inside_lsb_{};  ///< mean grey level just inside of each outline
  std::array<float, kDotCount> visible_{};      ///< of each outline, 0..1
};

}  // namespace

Verification verify_landmark(const ImageView& luma, const Eigen::Matrix3d& plane_to_luma,
                             const LandmarkGeometry& landmark, const BlobList& blobs, const Hypothesis& hypothesis,
                             double noise_lsb) noexcept {
  return Evidence(luma, plane_to_luma, landmark, hypothesis, noise_lsb).judge(blobs);
}

}  // namespace ninedot
