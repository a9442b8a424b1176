#include "detect/detector.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/contract.h"
#include "detect/blob_finder.h"
#include "detect/homography.h"
#include "detect/hypothesis.h"
#include "detect/numbering.h"
#include "detect/search_area.h"
#include "detect/verify.h"
#include "image/pyramid.h"

// picture -> blobs -> hypotheses -> the one that the grey levels confirm best -> numbered dots.
// The founding paper votes for ellipses in a Hough space; blobs by a local threshold need no votes, no parameter of
// size, and a hundredth of the time, and a shadow's edge across the sheet leaves them whole (measured: docs/method.md).

namespace ninedot {
namespace {

/// Blobs know nothing of the landmark: what is hidden, spoiled or at the picture's edge is told by the outlines. 15 of
/// the 16 directions in which verify.cpp looks at each.
constexpr float kWholeOutline = 0.9F;

/// Of a whole dot's area. A hard shadow across a dot costs a tenth of it; a dot that lacks as much as a seventh has its
/// centroid off by an eighth of its radius at most (a segment of a disc of that area).
constexpr double kCutShare = 0.85;
/// An outline that is off by a third of a pixel all around is off by 2 sqrt(pi) / 3 = 1.2 sqrt(area) in area.
constexpr double kOutlineSlack_px = 1.2;

/// Semi-minor axis of a ring dot in the picture that is asked about it: outlines are looked at 1.2 px inside of them
/// (verify.cpp), and that must not reach the other side.
constexpr double kSmallest_px = 2.5;

/// Of a refused guess, dots: with fewer it is nothing to show anybody.
constexpr std::ptrdiff_t kLeastSeen = 3;

/// As many guesses as sixteen landmarks make: three of each at most were confirmed.
constexpr std::size_t kMaxAccepted = 48;
/// P9 of a landmark so distant that its ring's dots leave no spots of their own, semi-major axis with its blur: dots of
/// 2 to 4 px, which the pixels' grid and the dark middle beside them hide from a threshold of half the size.
constexpr float kLeastDistant_px = 1.7F, kMostDistant_px = 5;
/// Of the semi-major axis: the outermost outlines lie at 3.65 radii of P9, blur makes the axis longer, not shorter.
constexpr float kCloserReach = 4.2F;
constexpr int kCloserSide_px = 2 * static_cast<int>(kCloserReach * kMostDistant_px + 2);
/// Each costs about a hundredth of a picture's search.
constexpr int kMostCloser = 16;
/// Of the paper's grey level, between P9 and the blank paper around it: ink has three quarters, half of that is left
/// of a disc of 4 px under a blur of its own radius.
constexpr int kInkShare = 4;

/// Of the ring's radius: two landmarks' middles are no nearer to each other, for sheets do not overlap.
constexpr double kApart_radii = 1.2;

}  // namespace

struct Detector::Workspace {
  /// A picture, or a part of one, and the blobs in it.
  struct Sight {
    Sight(int width_px, int height_px) : finder(width_px, height_px) {}
    SearchArea area;
    BlobFinder finder;
    BlobList blobs;
    double noise_lsb = 0;  ///< of the picture, before it was made larger
  };

  /// A hypothesis that the grey levels confirm.
  struct Accepted {
    const Hypothesis* hypothesis;
    Verification verification;
  };

  Workspace(const CameraModel& camera_model, const LandmarkGeometry& landmark_geometry,
            const DetectorOptions& detector_options)
      : camera(camera_model),
        landmark(landmark_geometry),
        options(detector_options),
        whole(camera_model.width_px, camera_model.height_px),
        window(camera_model.width_px, camera_model.height_px),
        close(2 * kCloserSide_px, 2 * kCloserSide_px),
        enlarged(2 * kCloserSide_px, 2 * kCloserSide_px),
        sorted(camera_model.width_px, camera_model.height_px) {}

  bool fits(const ImageView& luma) const noexcept {
    return luma.width_px == camera.width_px && luma.height_px == camera.height_px;
  }

  Result<LandmarkObservation> search_whole(const ImageView& luma, WorkBudget& budget) noexcept;
  Result<LandmarkObservation> search_near(const ImageView& luma, const LandmarkForecast& expected,
                                          WorkBudget& budget) noexcept;
  void guess_everything(const ImageView& luma, WorkBudget& budget) noexcept;
  void find_all(const ImageView& luma, WorkBudget& budget) noexcept;
  void look_closer(const ImageView& luma, WorkBudget& budget) noexcept;
  bool may_be_distant(const ImageView& luma, const Blob& blob) const noexcept;
  Result<LandmarkObservation> search_close(const ImageView& luma, const Blob& centre, WorkBudget& budget) noexcept;
  void centre_blob(const ImageView& luma, const Eigen::Matrix3d& H_px_plane, std::size_t dot,
                   Blob& blob) const noexcept;
  bool is_found(const LandmarkObservation& seen) const noexcept;

  static void look(const ImageView& luma, const SearchArea& area, Sight& sight, WorkBudget& budget) noexcept;
  void look_finer(const ImageView& luma, WorkBudget& budget) noexcept;
  enum class Numbering : bool { kLeftOut, kByPriors };
  Result<LandmarkObservation> match(const ImageView& luma, Sight& sight, int& allowance, GuessBegin& begin,
                                    Numbering numbering, WorkBudget& budget) noexcept;
  Verification verify(const ImageView& luma, const Sight& sight, const Hypothesis& hypothesis) const noexcept;
  bool verify_all(const ImageView& luma, const Sight& sight) noexcept;
  void note_refusal(const Hypothesis& hypothesis, const Verification& verification) noexcept;
  Result<LandmarkObservation> observe(const Sight& sight, const Accepted& from, Numbering numbering) const noexcept;
  bool is_cut(const Hypothesis& hypothesis, std::size_t dot, const Blob& blob) const noexcept;

  CameraModel camera;
  LandmarkGeometry landmark;
  DetectorOptions options;
  Sight whole, window, close;
  ImageBuffer enlarged;
  SortedBlobs sorted;
  HypothesisList hypotheses;
  InlineVector<Accepted, kMaxAccepted> accepted;  ///< the best first
  ObservationList found;
  std::optional<Hypothesis> nearest;  ///< of the guesses that the last search of the whole picture refused
  Verification refused;               ///< why it did
  GuessCuts cuts;
  GuessBegin coarse_begin, fine_begin, second_begin, all_begin;  ///< of searches of the whole picture
  std::size_t close_begin = 0;
};

/// Coarse to fine. Three quarters of all pixels are the picture's own, and a landmark nearer than about 4 m shows at
/// half the size as well: it is found there and measured where it is.
Result<LandmarkObservation> Detector::Workspace::search_whole(const ImageView& luma, WorkBudget& budget) noexcept {
  nearest.reset();
  look(luma, {0, 0, camera.width_px, camera.height_px, {1, BlobFinder::kLevels - 1}}, whole, budget);
  const Result<LandmarkObservation> coarse = with_half(budget.guesses, [&](int& half) {
    return match(luma, whole, half, coarse_begin, Numbering::kLeftOut, budget);  // it is looked at again
  });
  if (coarse)
    if (auto fine = search_near(luma, LandmarkForecast(*coarse, ForecastNumbers::kByPriors), budget)) return fine;
  look_finer(luma, budget);
  return match(luma, whole, budget.guesses, fine_begin, Numbering::kByPriors, budget);
}

Result<LandmarkObservation> Detector::Workspace::search_near(const ImageView& luma, const LandmarkForecast& expected,
                                                             WorkBudget& budget) noexcept {
  const auto area = search_area_around(expected.H_ray_plane, camera, landmark);
  if (!area) return fail(Errc::kNoLandmark, "the landmark has left the picture");
  look(luma, *area, window, budget);
  GuessBegin begin;
  Result<LandmarkObservation> seen = with_half(
      budget.guesses, [&](int& half) { return match(luma, window, half, begin, Numbering::kByPriors, budget); });
  if (!seen || expected.numbers == ForecastNumbers::kByPriors) return seen;
  if (const auto first = first_dot_by_forecast(seen->H_ray_plane, expected.H_ray_plane, landmark))
    return renumbered(*seen, *first);
  if (expected.numbers == ForecastNumbers::kCertain)
    return fail(Errc::kNoLandmark, "the landmark is not as it was foretold");
  return seen;
}

void Detector::Workspace::look(const ImageView& luma, const SearchArea& area, Sight& sight,
                               WorkBudget& budget) noexcept {
  sight.area = area;
  sight.finder.find_blobs(area.cut(luma), area.levels, sight.blobs, budget);
  sight.noise_lsb = sight.finder.noise_lsb();
  for (Blob& blob : sight.blobs) {
    blob.x_px += static_cast<float>(area.x_px);
    blob.y_px += static_cast<float>(area.y_px);
  }
}

/// The picture's own pixels in addition to what the whole picture was looked at by.
void Detector::Workspace::look_finer(const ImageView& luma, WorkBudget& budget) noexcept {
  if (whole.area.levels.first == 0) return;
  --whole.area.levels.first;
  whole.finder.add_finer_level(luma, whole.blobs, budget);
}

/// The landmark among the blobs at hand. \param allowance  guesses that it may try; fewer afterwards
Result<LandmarkObservation> Detector::Workspace::match(const ImageView& luma, Sight& sight, int& allowance,
                                                       GuessBegin& begin, Numbering numbering,
                                                       WorkBudget& budget) noexcept {
  sorted.assign(sight.blobs);
  hypotheses.clear();
  bool got_through = with_half(
      allowance, [&](int& half) { return guess_from_centre(sorted, landmark, half, begin.centre, hypotheses, cuts); });
  if (!verify_all(luma, sight)) {
    hypotheses.clear();
    got_through &= guess_from_ring(sorted, landmark, allowance, begin.middle, hypotheses, cuts);
    verify_all(luma, sight);
  }
  budget.is_overdrawn |= !got_through;
  if (accepted.empty()) return fail(Errc::kNoLandmark, "no landmark in the picture");
  return observe(sight, accepted[0], numbering);
}

/// All that may be a landmark, whatever is already known of some of it.
void Detector::Workspace::guess_everything(const ImageView& luma, WorkBudget& budget) noexcept {
  look_finer(luma, budget);
  sorted.assign(whole.blobs);
  hypotheses.clear();
  int& allowance = budget.second_guesses;
  const bool centres = with_half(allowance, [&](int& half) {
    return guess_from_centre(sorted, landmark, half, second_begin.centre, hypotheses, cuts);
  });
  const bool rings = guess_from_ring(sorted, landmark, allowance, second_begin.middle, hypotheses, cuts);
  budget.is_overdrawn |= !(centres && rings);
  verify_all(luma, whole);
}

/// Every landmark with a P9, at all levels in one go.
void Detector::Workspace::find_all(const ImageView& luma, WorkBudget& budget) noexcept {
  nearest.reset();
  look(luma, {0, 0, camera.width_px, camera.height_px, {1, BlobFinder::kLevels - 1}}, whole, budget);
  look_finer(luma, budget);
  sorted.assign(whole.blobs);
  hypotheses.clear();
  budget.is_overdrawn |= !guess_from_centre(sorted, landmark, budget.guesses, all_begin.centre, hypotheses, cuts);
  verify_all(luma, whole);
  found.clear();
  for (const Accepted& from : accepted)
    if (const auto seen = observe(whole, from, Numbering::kByPriors); seen && !is_found(*seen))
      (void)found.try_push_back(*seen);  // more than fit in there are refused where they are counted, in the map
  look_closer(luma, budget);
}

/// Whether it is one of those found.
bool Detector::Workspace::is_found(const LandmarkObservation& seen) const noexcept {
  const auto middle = [](const LandmarkObservation& o) { return map_point(o.H_ray_plane, Eigen::Vector2d::Zero()); };
  const auto reach = [&](const LandmarkObservation& o) {
    return landmark.ring_radius_m * jacobian_of_map(o.H_ray_plane, Eigen::Vector2d::Zero()).norm() /
           std::numbers::sqrt2;
  };
  return std::ranges::any_of(found, [&](const LandmarkObservation& other) {
    return (middle(seen) - middle(other)).norm() < kApart_radii * std::max(reach(seen), reach(other));
  });
}

/// Distant landmarks, one by one, around what may be their P9: enlarged, so that the threshold has the picture's own
/// pixels and no dot shares its darkest pixel with the next.
void Detector::Workspace::look_closer(const ImageView& luma, WorkBudget& budget) noexcept {
  int allowance = kMostCloser;
  const std::size_t count = whole.blobs.size();
  const std::size_t done = go_round(count, close_begin, [&](std::size_t i) {
    const Blob& blob = whole.blobs[i];
    if (!may_be_distant(luma, blob)) return true;
    if (!take_one(allowance)) return false;
    if (const auto seen = search_close(luma, blob, budget); seen && !is_found(*seen)) (void)found.try_push_back(*seen);
    return true;
  });
  budget.is_overdrawn |= done < count;
}

/// A small spot, dark enough for ink, with paper all around where the landmark is blank.
bool Detector::Workspace::may_be_distant(const ImageView& luma, const Blob& blob) const noexcept {
  const float semi_major_px = blob.semi_major_px();
  if (semi_major_px < kLeastDistant_px || semi_major_px > kMostDistant_px) return false;
  const auto grey_at = [&](double x_px, double y_px) {
    const auto x = static_cast<int>(std::lround(x_px)), y = static_cast<int>(std::lround(y_px));
    return luma.contains(x, y) ? static_cast<int>(luma.row(y)[x]) : -1;
  };
  const Eigen::Matrix2d axes = 2 * Eigen::LLT<Eigen::Matrix2d>(blob.moments_px2()).matrixL().toDenseMatrix();
  // Halfway between P9's outline and those of the ring's dots.
  const double blank = 0.5 * (1 + (landmark.ring_radius_m - landmark.dot_radius_m) / landmark.centre_radius_m);
  constexpr int kDirections = 8;
  int paper = 255;
  for (int i = 0; i < kDirections; ++i) {
    const double a_rad = i * 2 * std::numbers::pi / kDirections;
    const Eigen::Vector2d off_px = blank * axes * Eigen::Vector2d(std::cos(a_rad), std::sin(a_rad));
    paper = std::min(paper, grey_at(blob.x_px + off_px.x(), blob.y_px + off_px.y()));
  }
  return paper - grey_at(blob.x_px, blob.y_px) > paper / kInkShare;
}

Result<LandmarkObservation> Detector::Workspace::search_close(const ImageView& luma, const Blob& centre,
                                                              WorkBudget& budget) noexcept {
  const int reach_px = static_cast<int>(kCloserReach * centre.semi_major_px()) + 2;
  const int x_px = std::clamp(static_cast<int>(centre.x_px) - reach_px, 0, luma.width_px);
  const int y_px = std::clamp(static_cast<int>(centre.y_px) - reach_px, 0, luma.height_px);
  close.area = {
      x_px, y_px, std::min(2 * reach_px, luma.width_px - x_px), std::min(2 * reach_px, luma.height_px - y_px), {0, 0}};
  close.noise_lsb = whole.noise_lsb;
  enlarge(close.area.cut(luma), enlarged);
  close.finder.find_blobs(enlarged.view(), {0, 0}, close.blobs, budget);
  for (Blob& blob : close.blobs) {
    blob.x_px = 0.5F * (blob.x_px - 0.5F) + static_cast<float>(x_px);
    blob.y_px = 0.5F * (blob.y_px - 0.5F) + static_cast<float>(y_px);
    for (float* of_area : {&blob.area_px2, &blob.xx_px2, &blob.xy_px2, &blob.yy_px2}) *of_area *= 0.25F;
    blob.level = kEnlarged;
  }
  sorted.assign(close.blobs);
  hypotheses.clear();
  GuessBegin begin;
  budget.is_overdrawn |= !guess_from_centre(sorted, landmark, budget.guesses, begin.centre, hypotheses, cuts);
  if (!verify_all(luma, close)) return fail(Errc::kNoLandmark, "no landmark there");
  const Hypothesis& best = *accepted[0].hypothesis;
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    if (best.blob[dot] >= 0)
      centre_blob(luma, best.H_px_plane, dot, close.blobs[static_cast<std::size_t>(best.blob[dot])]);
  return observe(close, accepted[0], Numbering::kByPriors);
}

/// A threshold cuts a blurred dot where its neighbours' blur lets it; the middle of all its light is where it is.
void Detector::Workspace::centre_blob(const ImageView& luma, const Eigen::Matrix3d& H_px_plane, std::size_t dot,
                                      Blob& blob) const noexcept {
  const Eigen::Matrix2d J = jacobian_of_map(H_px_plane, landmark.centre_m(dot));
  if (!(J.determinant() > 0)) return;
  const Eigen::Matrix2d to_plane = J.inverse();
  // Halfway to what is next: another dot of the ring, or the ring.
  const double reach_m = dot == kCentreDot
                             ? 0.5 * (landmark.centre_radius_m + landmark.ring_radius_m - landmark.dot_radius_m)
                             : landmark.ring_radius_m * std::sin(std::numbers::pi / kRingDotCount);
  Eigen::Vector2d at(blob.x_px, blob.y_px);
  for (int round = 0; round < 2; ++round) {  // paper that is not quite white draws it to the window's middle
    const Eigen::Vector2d half = reach_m * J.rowwise().norm();
    const auto first_x = static_cast<int>(std::ceil(at.x() - half.x())), last_x = static_cast<int>(at.x() + half.x());
    const auto first_y = static_cast<int>(std::ceil(at.y() - half.y())), last_y = static_cast<int>(at.y() + half.y());
    if (!luma.contains(first_x, first_y) || !luma.contains(last_x, last_y)) return;
    const auto for_each = [&](auto&& use) {
      for (int y = first_y; y <= last_y; ++y)
        for (int x = first_x; x <= last_x; ++x) {
          const Eigen::Vector2d off(x - at.x(), y - at.y());
          if ((to_plane * off).squaredNorm() <= reach_m * reach_m) use(off, static_cast<int>(luma.row(y)[x]));
        }
    };
    int paper = 0;
    for_each([&](const Eigen::Vector2d&, int grey) { paper = std::max(paper, grey); });
    Eigen::Vector2d sum(0, 0);
    double weight = 0;
    for_each([&](const Eigen::Vector2d& off, int grey) { sum += (paper - grey) * off, weight += paper - grey; });
    if (!(weight > 0)) return;
    at += sum / weight;
  }
  blob.x_px = static_cast<float>(at.x()), blob.y_px = static_cast<float>(at.y());
}

/// Small dots are looked at in the picture itself, larger ones at a level of the pyramid where noise is averaged away.
Verification Detector::Workspace::verify(const ImageView& luma, const Sight& sight,
                                         const Hypothesis& hypothesis) const noexcept {
  const SearchArea& area = sight.area;
  const double noise_lsb = sight.noise_lsb;
  const Eigen::Matrix2d J = jacobian_of_map(hypothesis.H_px_plane, Eigen::Vector2d::Zero());
  const double semi_minor_px = landmark.dot_radius_m * std::abs(J.determinant()) / std::max(J.norm(), 1e-9);
  int level = 0;
  while (level <= area.levels.last && semi_minor_px > kSmallest_px * (2 << level)) ++level;
  if (level == 0) return verify_landmark(luma, hypothesis.H_px_plane, landmark, sight.blobs, hypothesis, noise_lsb);
  const double scale = 1.0 / (1 << level);
  Eigen::Matrix3d to_level = Eigen::Matrix3d::Identity();
  to_level(0, 0) = to_level(1, 1) = scale;
  to_level(0, 2) = (0.5 - area.x_px) * scale - 0.5;
  to_level(1, 2) = (0.5 - area.y_px) * scale - 0.5;
  return verify_landmark(sight.finder.picture_at(level), to_level * hypothesis.H_px_plane, landmark, sight.blobs,
                         hypothesis, noise_lsb * scale);
}

/// Keeps those that are confirmed, the best first. \return  whether there is one
bool Detector::Workspace::verify_all(const ImageView& luma, const Sight& sight) noexcept {
  accepted.clear();
  for (const Hypothesis& hypothesis : hypotheses) {
    const Verification v = verify(luma, sight, hypothesis);
    if (!v.accepted()) {
      if (&sight == &whole) note_refusal(hypothesis, v);
      continue;
    }
    if (accepted.full()) {
      if (v.score <= accepted[accepted.size() - 1].verification.score) continue;
      accepted.pop_back();
    }
    (void)accepted.try_push_back({&hypothesis, v});  // there is room
    for (std::size_t i = accepted.size() - 1; i > 0 && accepted[i - 1].verification.score < v.score; --i)
      std::swap(accepted[i - 1], accepted[i]);
  }
  return !accepted.empty();
}

void Detector::Workspace::note_refusal(const Hypothesis& hypothesis, const Verification& verification) noexcept {
  if (nearest && verification.score <= refused.score) return;
  nearest = hypothesis;
  refused = verification;
}

/// A dot that something hides in part has an outline all around all the same, but it is smaller than the others say.
bool Detector::Workspace::is_cut(const Hypothesis& hypothesis, std::size_t dot, const Blob& blob) const noexcept {
  const double radius_m = landmark.radius_m(dot);
  const double whole_px2 = std::numbers::pi * radius_m * radius_m *
                           jacobian_of_map(hypothesis.H_px_plane, landmark.centre_m(dot)).determinant();
  return static_cast<double>(blob.area_px2) < whole_px2 * (kCutShare - kOutlineSlack_px / std::sqrt(whole_px2));
}

Result<LandmarkObservation> Detector::Workspace::observe(const Sight& sight, const Accepted& from,
                                                         Numbering numbering) const noexcept {
  const Hypothesis& hypothesis = *from.hypothesis;
  LandmarkObservation seen;
  InlineVector<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    DotObservation& d = seen.dots[dot];
    d.visible_fraction = from.verification.visible_fraction[dot];
    if (hypothesis.blob[dot] < 0) continue;
    const Blob& blob = sight.blobs[static_cast<std::size_t>(hypothesis.blob[dot])];
    d.seen = d.visible_fraction >= kWholeOutline && !is_cut(hypothesis, dot, blob);
    d.centroid_px = {blob.x_px, blob.y_px};
    set_outline(blob.moments_px2(), d);
    if (d.seen) ++seen.seen_count;
    const auto ray = camera.normalised_from_pixel(d.centroid_px);
    if (!ray) return tl::unexpected<Error>(ray.error());
    EXPECTS(points.try_push_back({landmark.centre_m(dot), *ray}));  // as many as there are dots
  }
  if (!fit_plane_map(points.span(), seen.H_ray_plane))
    return fail(Errc::kPoseDegenerate, "the visible dots lie on a line");
  if (numbering == Numbering::kLeftOut) return seen;
  seen.numbering_chi2 = numbering_costs(points.span(), seen.H_ray_plane, landmark, options.upright);
  const auto likeliest = std::min_element(seen.numbering_chi2.begin(), seen.numbering_chi2.end());
  return renumbered(seen, static_cast<int>(likeliest - seen.numbering_chi2.begin()));
}

Detector::Detector(const CameraModel& camera, const LandmarkGeometry& landmark, const DetectorOptions& options)
    : workspace_(std::make_unique<Workspace>(camera, landmark, options)) {}

Detector::~Detector() = default;

Result<std::span<const LandmarkObservation>> Detector::find_landmarks(const ImageView& luma,
                                                                      WorkBudget& budget) noexcept {
  Workspace& w = *workspace_;
  if (!w.fits(luma)) return fail(Errc::kFrameSize, "the frame's size is not the calibration's");
  NINEDOT_TRY(const LandmarkObservation seen, w.search_whole(luma, budget));
  w.found.clear();
  (void)w.found.try_push_back(seen);  // the only one
  return w.found.span();
}

Result<std::span<const LandmarkObservation>> Detector::find_more_landmarks(const ImageView& luma,
                                                                           WorkBudget& budget) noexcept {
  Workspace& w = *workspace_;
  if (!w.fits(luma)) return fail(Errc::kFrameSize, "the frame's size is not the calibration's");
  w.guess_everything(luma, budget);
  w.found.clear();
  for (const Workspace::Accepted& accepted : w.accepted.span().first(std::min(w.accepted.size(), kMaxGuesses)))
    if (const auto seen = w.observe(w.whole, accepted, Workspace::Numbering::kByPriors))
      (void)w.found.try_push_back(*seen);  // kMaxGuesses is less than it holds
  if (w.found.empty()) return fail(Errc::kNoLandmark, "no landmark in the picture");
  return w.found.span();
}

Result<std::span<const LandmarkObservation>> Detector::find_all_landmarks(const ImageView& luma,
                                                                          WorkBudget& budget) noexcept {
  Workspace& w = *workspace_;
  if (!w.fits(luma)) return fail(Errc::kFrameSize, "the frame's size is not the calibration's");
  w.find_all(luma, budget);
  if (w.found.empty()) return fail(Errc::kNoLandmark, "no landmark in the picture");
  return w.found.span();
}

Result<LandmarkObservation> Detector::find_landmark_near(const ImageView& luma, const LandmarkForecast& expected,
                                                         WorkBudget& budget) noexcept {
  Workspace& w = *workspace_;
  if (!w.fits(luma)) return fail(Errc::kFrameSize, "the frame's size is not the calibration's");
  return w.search_near(luma, expected, budget);
}

FailedSearch Detector::failed_search() const noexcept {
  const Workspace& w = *workspace_;
  FailedSearch failed;
  failed.spots = w.whole.blobs.span();
  failed.noise_lsb = w.whole.noise_lsb;
  const auto is_seen = [](float visible_fraction) { return visible_fraction >= kSeenOutline; };
  if (!w.nearest || std::ranges::count_if(w.refused.visible_fraction, is_seen) < kLeastSeen) return failed;
  failed.refusal = w.refused.refusal;
  failed.contrast_lsb = w.refused.contrast_lsb;
  for (std::size_t i = 0; i < kDotCount; ++i) {
    DotObservation& dot = failed.dots[i];
    const Eigen::Vector2d centre_m = w.landmark.centre_m(i);
    dot.visible_fraction = w.refused.visible_fraction[i];
    dot.seen = is_seen(dot.visible_fraction);
    dot.centroid_px = map_point(w.nearest->H_px_plane, centre_m);
    set_outline(disc_moments(jacobian_of_map(w.nearest->H_px_plane, centre_m), w.landmark.radius_m(i)), dot);
  }
  return failed;
}

WorkCounts Detector::counts() const noexcept {
  const Workspace& w = *workspace_;
  return {.runs_cut = w.whole.finder.runs_cut() + w.window.finder.runs_cut(),
          .blobs_cut = w.whole.finder.blobs_cut() + w.window.finder.blobs_cut(),
          .neighbours_cut = w.cuts.neighbours,
          .hypotheses_cut = w.cuts.hypotheses};
}

}  // namespace ninedot
