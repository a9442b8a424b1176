#include "pose/outline_shape.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/inline_vector.h"

namespace ninedot {
namespace {

constexpr double kShapeSigma_px = 1;    // prior: what the pixels say nothing of stays zero
constexpr double kBlurSigma_px2 = 0.1;  // prior of a dot's own blur: it is the same for all
// What noise makes of the square of an amplitude of two parts, in its variances: 2 ln 2 in the median of many, and so
// much more in the median of nine once in thirty.
constexpr double kNoiseVariances = 2.9;
constexpr double kSizeSigmas = 1.5;  // likewise, of one part and the median's
// In the variances of one dot, P9: so much once in a hundred. One that is less sure than this share of its short
// semi-axis can't be told from a square, which has 0.11 to 0.2.
constexpr double kCentreVariances = 9.2, kCentreSure = 0.035;
// An outline that noise leaves less sure than this share of the short semi-axis has no shape to speak of.
constexpr double kLeastSure = 0.1;
constexpr int kLeastDots = 3;
// So many pixels of a dot say enough of its shape, thinned to every fourth at most: they leave its parts sure to 0.035
// px where noise is a twentieth of the contrast, a tenth of what kMostFourth (pose_of_outlines.cpp) is of a dot of 8
// px.
constexpr int kEnoughPixels = 60, kMostThinned = 4;
// A dot that is printed elsewhere leaves paper in its place and ink beside it. Places off the outlines' blur, in radii
// of a ring's dot from where it belongs; what hides a dot has the grey of paper in some of them by chance.
constexpr int kDirections = 16, kLeastBare = 4, kLeastInked = 2;
constexpr double kInside = 0.7;
constexpr std::array<double, 6> kBeside{1.3, 1.6, 2.0, 2.4, 2.8, 3.2};  // the next dot begins at 3.8
// P9 that is printed aside leaves paper in its place and ink on the opposite side of it, in radii of its own; what
// hides it has both on the side that it comes from.
constexpr double kInsideCentre = 0.8, kBesideCentre = 1.2;
constexpr int kAsideDirections = 12;
// A dot may be hidden by something that is as white as paper; so many, each of them white all over, are not there. Any
// dots fit where there are few: then one is enough less.
constexpr int kLeastBlank = 3, kFewDots = 5, kLeastBlankOfFew = 2;
constexpr double kAroundDot = 1.6;           // radii: the sheet's paper about a dot, far from the next one
constexpr double kThere = 0.75;              // of its outline: a dot that is where it belongs
constexpr double kPaper = 0.15, kInk = 0.5;  // how much darker than paper, of the contrast
// Likewise. In a shadow, which what hides a dot casts beside it, paper has the grey that the thing itself may have.
// Where it is deep that says nothing; a dot that is printed elsewhere leaves ink as well, blank places that grey alone.
constexpr double kShaded = 0.65, kWhite = 0.35;

// Of the blank paper's way from P9's outline to those of the ring: circles that are looked along, in so many
// directions, and the two beside them on which a spot's directions are paper.
constexpr std::array<double, 3> kBetween{0.31, 0.5, 0.69};
constexpr double kBetweenInner = 0.16, kBetweenOuter = 0.86;
constexpr std::size_t kAround = 24;
constexpr double kSpot = 0.75;  // shadows are not as dark, in contrasts

constexpr double kNoEdge = 3;  // sigmas of the blur from an outline: beyond, ink is ink
// Of its outline: an edge across a dot's middle leaves half, and what hides the rest may be dark by chance.
constexpr double kMostly = 0.9;

// The unknowns in place of the pose's and the offset's (outline_columns.h).
enum Part : Eigen::Index {
  kAllAround = 0,
  kCos1 = 1,
  kSin1 = 2,
  kCos2 = 3,
  kSin2 = 4,
  kCos4 = 5,
  kSin4 = 6,
  kShapeUnknowns = 7
};

using Amounts = InlineVector<double, kDotCount>;

double square(double x) noexcept { return x * x; }
double root_beyond(double squared, double by_noise) noexcept { return std::sqrt(std::max(squared - by_noise, 0.0)); }

/// Of the first `count` unknowns: of the diagonal of (L L^T)^-1, whose columns are those of L^-1 times themselves.
double largest_variance(const Eigen::LLT<UnknownMatrix>& factors, Eigen::Index count) noexcept {
  const UnknownMatrix& L = factors.matrixLLT();
  double largest = 0;
  for (Eigen::Index unknown = 0; unknown < count; ++unknown) {
    UnknownVector column = UnknownVector::Unit(unknown);  // of L^-1, by forward substitution
    for (Eigen::Index i = unknown; i < kUnknowns; ++i) {
      for (Eigen::Index k = unknown; k < i; ++k) column(i) -= L(i, k) * column(k);
      column(i) /= L(i, i);
    }
    largest = std::max(largest, column.squaredNorm());
  }
  return largest;
}

double middle_of(Amounts& amounts) noexcept {
  const auto middle = amounts.begin() + static_cast<std::ptrdiff_t>(amounts.size() / 2);
  std::nth_element(amounts.begin(), middle, amounts.end());
  return *middle;
}

}  // namespace

OutlineShape shape_of_outlines(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state,
                               const std::array<double, kDotCount>& visible_share, double noise_variance_lsb2,
                               const DotAxes& dot_axes) noexcept {
  std::array<UnknownMatrix, kDotCount> normal;
  std::array<UnknownVector, kDotCount> gradient;
  normal.fill(UnknownMatrix::Zero());
  gradient.fill(UnknownVector::Zero());
  std::array<int, kDotCount> pixels_of_dot{};
  for (const OutlineGroup& group : pixels.groups.span()) pixels_of_dot[group.dot] += group.count;
  // What hides a part of a dot gives it another shape: only where there are too few whole ones do such dots count. P9
  // does, whose own outline says whether it lies aside.
  const auto whole = std::ranges::count_if(visible_share, [](double share) { return share >= kMostly; });
  const double least_of_ring = whole >= kLeastDots ? kMostly : kMinVisible;
  GroupFitter fitter(pixels, landmark, state, Asked::kShape);
  GroupFit fit;
  for (const OutlineGroup& group : pixels.groups.span()) {
    if (visible_share[group.dot] < (group.dot == kCentreDot ? kMinVisible : least_of_ring)) continue;
    const int every = std::clamp(pixels_of_dot[group.dot] / kEnoughPixels, 1, kMostThinned);
    fitter.fit(group, fit, static_cast<std::size_t>(every));
    if (!fit.usable) continue;
    normal[group.dot] += fit.normal / noise_variance_lsb2;
    gradient[group.dot] += fit.gradient / noise_variance_lsb2;
  }

  Amounts size_px, size_sigma_px, second_px, fourth_px;  // as many as dots: no push can fail
  double centre_px = 0, centre_size_px = 0, centre_sigma_px = 0, centre_fourth_px = 0;
  const double centre_minor_px = dot_axes.semi_minor_px * landmark.centre_radius_m / landmark.dot_radius_m;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    UnknownMatrix& N = normal[dot];
    if (!(N(kAllAround, kAllAround) > 0)) continue;
    N.diagonal().head<kShapeUnknowns>().array() += 1 / (kShapeSigma_px * kShapeSigma_px);
    N.diagonal().tail<kUnknowns - kShapeUnknowns>().array() += 1 / (kBlurSigma_px2 * kBlurSigma_px2);
    const Eigen::LLT<UnknownMatrix> factors(N);
    const UnknownVector part_px = factors.solve(gradient[dot]);
    const double sigma_px = std::sqrt(largest_variance(factors, kShapeUnknowns));
    const auto amplitude_px = [&](Part cosine, Part sine, double noise_variances = kNoiseVariances) {
      return root_beyond(square(part_px(cosine)) + square(part_px(sine)), noise_variances * square(sigma_px));
    };
    if (dot == kCentreDot && sigma_px < kCentreSure * centre_minor_px)
      centre_fourth_px = amplitude_px(kCos4, kSin4, kCentreVariances);
    if (!(sigma_px < kLeastSure * dot_axes.semi_minor_px)) continue;
    if (dot == kCentreDot) {
      centre_px = amplitude_px(kCos1, kSin1);
      centre_size_px = part_px(kAllAround), centre_sigma_px = sigma_px;
    }
    (void)size_px.try_push_back(part_px(kAllAround));
    (void)size_sigma_px.try_push_back(sigma_px);
    (void)second_px.try_push_back(amplitude_px(kCos2, kSin2));
    (void)fourth_px.try_push_back(amplitude_px(kCos4, kSin4));
  }
  const double centre_fourth = centre_fourth_px / centre_minor_px;
  if (size_px.size() < kLeastDots) return {.is_unknown = true, .centre_fourth = centre_fourth};

  Amounts sorted = size_px;
  const double usual_px = middle_of(sorted);
  if (centre_sigma_px > 0)
    centre_size_px = root_beyond(square(centre_size_px - usual_px), square(kSizeSigmas * centre_sigma_px));
  for (std::size_t i = 0; i < size_px.size(); ++i)
    size_px[i] = root_beyond(square(size_px[i] - usual_px), square(kSizeSigmas * size_sigma_px[i]));
  const double mean_px = dot_axes.mean_px(), semi_minor_px = dot_axes.semi_minor_px;
  return {.size = middle_of(size_px) / mean_px,
          .second = middle_of(second_px) / semi_minor_px,
          .fourth = middle_of(fourth_px) / semi_minor_px,
          .centre = centre_px / mean_px,
          .centre_size = centre_size_px / mean_px,
          .centre_fourth = centre_fourth};
}

namespace {

/// Grey levels about a pose, by the light of its outlines.
struct SheetLight {
  /// How much darker than paper a point of the sheet is, in contrasts; none: it is not in the picture.
  std::optional<double> darkness_at(const Eigen::Vector2d& plane_m) const noexcept {
    const Eigen::Vector3d p = T_camera_landmark.rotation.col(0) * plane_m.x() +
                              T_camera_landmark.rotation.col(2) * plane_m.y() + T_camera_landmark.translation_m;
    if (!(p.z() > 0)) return std::nullopt;
    const Eigen::Vector2d px = camera.pixel_from_normalised(p.hnormalized());
    if (!(px.x() >= 0 && px.y() >= 0 && px.x() <= luma.width_px - 1 && px.y() <= luma.height_px - 1))
      return std::nullopt;
    const Eigen::Vector2d from_corner_px = px.array() + 0.5;
    const int grey_lsb = luma.at(static_cast<int>(from_corner_px.x()), static_cast<int>(from_corner_px.y()));
    return (fit.paper_lsb - grey_lsb) / fit.contrast_lsb;
  }

  const ImageView& luma;
  const CameraModel& camera;
  const CameraFromLandmark& T_camera_landmark;
  const OutlineFit& fit;
};

/// A point of the sheet beside a dot of the ring. \param i  of kDirections \param radii  from its middle
Eigen::Vector2d beside(const LandmarkGeometry& landmark, std::size_t dot, int i, double radii) noexcept {
  const double a_rad = i * 2 * std::numbers::pi / kDirections;
  return landmark.centre_m(dot) + radii * landmark.dot_radius_m * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad));
}

bool is_centre_aside(const SheetLight& light, const LandmarkGeometry& landmark) noexcept {
  const Eigen::Rotation2Dd on(2 * std::numbers::pi / kAsideDirections);
  Eigen::Vector2d radius(landmark.radius_m(kCentreDot), 0);
  for (int i = 0; i < kAsideDirections; ++i, radius = on * radius) {
    const auto inside = light.darkness_at(landmark.centre_m(kCentreDot) + kInsideCentre * radius);
    if (inside && std::abs(*inside) < kPaper &&
        light.darkness_at(landmark.centre_m(kCentreDot) - kBesideCentre * radius) > kInk)
      return true;
  }
  return false;
}

/// How much darker than the landmark's the paper is in each place of the ring, in contrasts: about the dots that are
/// there, and on the way from one of them to the next in the places between. Light slopes.
std::array<double, kRingDotCount> darkness_of_paper(const SheetLight& light, const LandmarkGeometry& landmark,
                                                    const std::array<bool, kRingDotCount>& is_there) noexcept {
  std::array<double, kRingDotCount> darkness{};
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
    if (!is_there[dot]) continue;
    double sum = 0;
    int count = 0;
    for (int i = 0; i < kDirections; ++i) {
      const auto around = light.darkness_at(beside(landmark, dot, i, kAroundDot));
      if (around) sum += *around, ++count;
    }
    if (count > 0) darkness[dot] = sum / count;
  }
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
    if (is_there[dot]) continue;
    std::size_t before = 1, after = 1;
    while (before < kRingDotCount && !is_there[(dot + kRingDotCount - before) % kRingDotCount]) ++before;
    while (after < kRingDotCount && !is_there[(dot + after) % kRingDotCount]) ++after;
    if (before == kRingDotCount) return darkness;  // none is there
    const double a = darkness[(dot + kRingDotCount - before) % kRingDotCount],
                 b = darkness[(dot + after) % kRingDotCount];
    darkness[dot] = a + (b - a) * static_cast<double>(before) / static_cast<double>(before + after);
  }
  return darkness;
}

}  // namespace

int count_hollow(const ImageView& luma, const CameraModel& camera, const LandmarkGeometry& landmark,
                 const CameraFromLandmark& T_camera_landmark, const std::array<double, kDotCount>& visible_share,
                 const OutlineFit& fit, double blur_px) noexcept {
  const SheetLight light{luma, camera, T_camera_landmark, fit};
  // The short way across an inclined dot.
  const double px_per_m = foreshortening(T_camera_landmark) * camera.fx_px / T_camera_landmark.translation_m.norm();
  int hollow = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (visible_share[dot] < kMostly || px_per_m * landmark.radius_m(dot) < kNoEdge * blur_px) continue;
    const auto middle = light.darkness_at(landmark.centre_m(dot));
    hollow += middle && *middle < kInk;
  }
  return hollow;
}

int count_spots(const ImageView& luma, const CameraModel& camera, const LandmarkGeometry& landmark,
                const CameraFromLandmark& T_camera_landmark, const std::array<double, kDotCount>& visible_share,
                const OutlineFit& fit) noexcept {
  if (!std::ranges::all_of(visible_share, [](double share) { return share >= kMostly; })) return 0;
  const SheetLight light{luma, camera, T_camera_landmark, fit};
  std::array<Eigen::Vector2d, kAround> directions;
  directions[0] = {1, 0};
  const Eigen::Rotation2Dd on(2 * std::numbers::pi / kAround);
  for (std::size_t i = 1; i < kAround; ++i) directions[i] = on * directions[i - 1];
  const double blank_m = landmark.ring_radius_m - landmark.dot_radius_m - landmark.centre_radius_m;
  const auto radius_m = [&](double share) { return landmark.centre_radius_m + share * blank_m; };
  const std::array<double, kBetween.size()> between_m{radius_m(kBetween[0]), radius_m(kBetween[1]),
                                                      radius_m(kBetween[2])};
  const auto has_ink = [&](const Eigen::Vector2d& direction) {
    return std::ranges::any_of(between_m, [&](double r_m) { return light.darkness_at(r_m * direction) > kSpot; });
  };
  if (std::ranges::none_of(directions, has_ink)) return 0;  // most landmarks
  enum class Seen { kPaper, kInk, kOther };
  const auto seen_towards = [&](const Eigen::Vector2d& direction) {
    const auto is_paper = [&](double r_m) {
      const auto darkness = light.darkness_at(r_m * direction);
      return darkness && std::abs(*darkness) < kPaper;
    };
    if (!is_paper(radius_m(kBetweenInner)) || !is_paper(radius_m(kBetweenOuter))) return Seen::kOther;
    if (has_ink(direction)) return Seen::kInk;
    return std::ranges::all_of(between_m, is_paper) ? Seen::kPaper : Seen::kOther;
  };
  // A spot counts where paper follows on ink; directions between, on its blurred edge, change nothing.
  int spots = 0;
  bool on_ink = false;
  for (std::size_t i = 0; i <= kAround; ++i) {
    const Seen seen = seen_towards(directions[i % kAround]);
    spots += on_ink && seen == Seen::kPaper;
    if (seen != Seen::kOther) on_ink = seen == Seen::kInk;
  }
  return spots;
}

int count_absent(const ImageView& luma, const CameraModel& camera, const LandmarkGeometry& landmark,
                 const CameraFromLandmark& T_camera_landmark, const std::array<double, kDotCount>& visible_share,
                 const OutlineFit& fit) noexcept {
  std::array<bool, kRingDotCount> is_there;
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) is_there[dot] = visible_share[dot] >= kThere;
  const auto is_missing = [&](std::size_t dot) { return !is_there[dot % kRingDotCount]; };
  const SheetLight light{luma, camera, T_camera_landmark, fit};
  const auto paper = darkness_of_paper(light, landmark, is_there);
  int absent = 0, blank = 0;
  for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
    const bool before = is_missing(dot + 7), after = is_missing(dot + 1);
    const bool row_is_short = !(before && (after || is_missing(dot + 6))) && !(after && is_missing(dot + 2));
    if (!is_missing(dot) || paper[dot] > kShaded) continue;
    const double lit = 1 - paper[dot] * fit.contrast_lsb / fit.paper_lsb;  // contrasts are as much smaller there
    const auto is_paper = [&](const Eigen::Vector2d& plane_m) {
      const auto darkness = light.darkness_at(plane_m);
      return darkness && std::abs(*darkness - paper[dot]) < kPaper * lit;
    };
    int bare = 0, inked = 0;
    for (int i = 0; i < kDirections; ++i) {
      bare += is_paper(beside(landmark, dot, i, kInside));
      for (const double radii : kBeside)
        inked += light.darkness_at(beside(landmark, dot, i, radii)) > paper[dot] + kInk * lit;
    }
    if (row_is_short && bare >= kLeastBare && inked >= kLeastInked) ++absent;
    blank += paper[dot] < kWhite && visible_share[dot] < kMinVisible && bare == kDirections &&
             is_paper(landmark.centre_m(dot));
  }
  if (is_centre_aside(light, landmark)) ++absent;
  const bool few = std::ranges::count(is_there, true) <= kFewDots;
  return absent + (blank >= (few ? kLeastBlankOfFew : kLeastBlank) ? blank : 0);
}

}  // namespace ninedot
