#include "detect/detector.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/contract.h"
#include "detect/blob_finder.h"
#include "detect/close_look.h"
#include "detect/homography.h"
#include "detect/hypothesis.h"
#include "detect/numbering.h"
#include "detect/search_area.h"
#include "detect/verify.h"

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
/// Windows that CloseLook makes of one picture, 420,000 instructions each (callgrind, rendered rooms): together as much
/// as all that is searched before them.
constexpr int kMostCloser = 8;
/// Of the ring's radius: two landmarks' middles are no nearer to each other, for sheets do not overlap.
constexpr double kApart_radii = 1.2;

Eigen::Vector2d middle_of(const LandmarkObservation& seen) noexcept {
  return map_point(seen.H_ray_plane, Eigen::Vector2d::Zero());
}

}  // namespace

struct Detector::Workspace {
  /// A picture, or a part of one, and the blobs in it.
  struct Sight {
    explicit Sight(const CameraModel& camera) : finder(camera.width_px, camera.height_px) {}
    SearchArea area;
    BlobFinder finder;
    BlobList blobs;
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
        whole(camera_model),
        window(camera_model),
        close(landmark_geometry),
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
  Result<LandmarkObservation> search_close(const ImageView& luma, const Blob& centre, WorkBudget& budget) noexcept;
  void keep_distinct(const LandmarkObservation& seen) noexcept;
  double reach_of(const LandmarkObservation& seen) const noexcept;
  bool is_of_found(const Blob& blob) const noexcept;

  static void look(const ImageView& luma, const SearchArea& area, Sight& sight, WorkBudget& budget) noexcept;
  void look_finer(const ImageView& luma, WorkBudget& budget) noexcept;
  enum class Numbering : bool { kLeftOut, kByPriors };
  Result<LandmarkObservation> match(const ImageView& luma, Sight& sight, int& allowance, GuessBegin& begin,
                                    Numbering numbering, WorkBudget& budget) noexcept;
  Verification verify(const ImageView& luma, const Sight& sight, const Hypothesis& hypothesis) const noexcept;
  template <typename VerifyOne>
  bool keep_confirmed(VerifyOne&& verify_one) noexcept;
  bool verify_all(const ImageView& luma, const Sight& sight) noexcept;
  void note_refusal(const Hypothesis& hypothesis, const Verification& verification) noexcept;
  void note_three(const Hypothesis& hypothesis, const Verification& verification) noexcept;
  Result<LandmarkObservation> observe(const BlobList& blobs, const Accepted& from, Numbering numbering) const noexcept;
  bool is_cut(const Hypothesis& hypothesis, std::size_t dot, const Blob& blob) const noexcept;

  CameraModel camera;
  LandmarkGeometry landmark;
  DetectorOptions options;
  Sight whole, window;
  CloseLook close;
  SortedBlobs sorted;
  HypothesisList hypotheses;
  InlineVector<Accepted, kMaxAccepted> accepted;  ///< the best first
  ObservationList found;
  std::optional<Hypothesis> nearest;  ///< of the guesses that the last search of the whole picture refused
  Verification refused;               ///< why it did
  std::optional<Hypothesis> three;    ///< of `whole`: the likeliest of three dots; where nothing was found
  Verification three_verification;
  GuessCuts cuts;
  GuessBegin coarse_begin, fine_begin, second_begin, all_begin;  ///< of searches of the whole picture
  std::size_t close_begin = 0;
};

/// Coarse to fine. Three quarters of all pixels are the picture's own, and a landmark nearer than about 4 m shows at
/// half the size as well: it is found there and measured where it is.
Result<LandmarkObservation> Detector::Workspace::search_whole(const ImageView& luma, WorkBudget& budget) noexcept {
  nearest.reset();
  three.reset();
  look(luma, {0, 0, camera.width_px, camera.height_px, {1, BlobFinder::kLevels - 1}}, whole, budget);
  const Result<LandmarkObservation> coarse = with_half(budget.guesses, [&](int& half) {
    return match(luma, whole, half, coarse_begin, Numbering::kLeftOut, budget);  // it is looked at again
  });
  if (coarse)
    if (auto fine = search_near(luma, LandmarkForecast(*coarse, ForecastNumbers::kByPriors), budget)) return fine;
  look_finer(luma, budget);
  three.reset();  // its blobs were others
  Result<LandmarkObservation> fine = match(luma, whole, budget.guesses, fine_begin, Numbering::kByPriors, budget);
  if (fine) three.reset();
  return fine;
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
  return observe(sight.blobs, accepted[0], numbering);
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
    if (const auto seen = observe(whole.blobs, from, Numbering::kByPriors)) keep_distinct(*seen);
  look_closer(luma, budget);
  three.reset();  // it is of other blobs, and what is found here is enough
}

/// Of a landmark, where its middle is: half the ring's size, as it lies in the directions of sight.
double Detector::Workspace::reach_of(const LandmarkObservation& seen) const noexcept {
  return landmark.ring_radius_m * jacobian_of_map(seen.H_ray_plane, Eigen::Vector2d::Zero()).norm() /
         std::numbers::sqrt2;
}

/// Adds a landmark to those found unless it is one of them.
void Detector::Workspace::keep_distinct(const LandmarkObservation& seen) noexcept {
  for (const LandmarkObservation& other : found)
    if ((middle_of(seen) - middle_of(other)).norm() < kApart_radii * std::max(reach_of(seen), reach_of(other))) return;
  (void)found.try_push_back(seen);  // more than fit in there are refused where they are counted, in the map
}

/// Whether a spot belongs to a landmark that is found.
bool Detector::Workspace::is_of_found(const Blob& blob) const noexcept {
  const auto ray = camera.normalised_from_pixel({blob.x_px, blob.y_px});
  return ray && std::ranges::any_of(found, [&](const LandmarkObservation& other) {
           return (*ray - middle_of(other)).norm() < kApart_radii * reach_of(other);
         });
}

/// Keeps those that are confirmed, the best first. \param verify_one  of a hypothesis \return  whether there is one
template <typename VerifyOne>
bool Detector::Workspace::keep_confirmed(VerifyOne&& verify_one) noexcept {
  accepted.clear();
  for (const Hypothesis& hypothesis : hypotheses) {
    const Verification v = verify_one(hypothesis);
    if (!v.accepted()) continue;
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

bool Detector::Workspace::verify_all(const ImageView& luma, const Sight& sight) noexcept {
  return keep_confirmed([&](const Hypothesis& hypothesis) {
    const Verification v = verify(luma, sight, hypothesis);
    if (!v.accepted() && &sight == &whole) {
      note_refusal(hypothesis, v);
      note_three(hypothesis, v);
    }
    return v;
  });
}

/// Distant landmarks, one by one, around what may be their P9.
void Detector::Workspace::look_closer(const ImageView& luma, WorkBudget& budget) noexcept {
  int allowance = kMostCloser;
  const std::size_t count = whole.blobs.size();
  const std::size_t done = go_round(count, close_begin, [&](std::size_t i) {
    const Blob& blob = whole.blobs[i];
    if (!close.may_be_centre(luma, blob) || is_of_found(blob)) return true;
    if (!take_one(allowance)) return false;
    if (const auto seen = search_close(luma, blob, budget)) keep_distinct(*seen);
    return true;
  });
  budget.is_overdrawn |= done < count;
}

Result<LandmarkObservation> Detector::Workspace::search_close(const ImageView& luma, const Blob& centre,
                                                              WorkBudget& budget) noexcept {
  BlobList& blobs = close.blobs_around(luma, centre, budget);
  sorted.assign(blobs);
  hypotheses.clear();
  GuessBegin begin;
  budget.is_overdrawn |= !guess_from_centre(sorted, landmark, budget.guesses, begin.centre, hypotheses, cuts);
  const bool is_confirmed = keep_confirmed([&](const Hypothesis& hypothesis) {
    return verify_landmark(luma, hypothesis.H_px_plane, landmark, blobs, hypothesis, whole.finder.noise_lsb());
  });
  if (!is_confirmed) return fail(Errc::kNoLandmark, "no landmark there");
  close.centre_blobs(luma, *accepted[0].hypothesis);
  return observe(blobs, accepted[0], Numbering::kByPriors);
}

/// Small dots are looked at in the picture itself, smoothed where it is noisy, larger ones at a level of the pyramid
/// where noise is averaged away.
Verification Detector::Workspace::verify(const ImageView& luma, const Sight& sight,
                                         const Hypothesis& hypothesis) const noexcept {
  const SearchArea& area = sight.area;
  const Eigen::Matrix2d J = jacobian_of_map(hypothesis.H_px_plane, Eigen::Vector2d::Zero());
  const double semi_minor_px = landmark.dot_radius_m * std::abs(J.determinant()) / std::max(J.norm(), 1e-9);
  int level = 0;
  while (level <= area.levels.last && semi_minor_px > kSmallest_px * (2 << level)) ++level;
  const double noise_lsb = sight.finder.noise_at_lsb(level);
  if (level == 0 && !sight.finder.is_smoothed())
    return verify_landmark(luma, hypothesis.H_px_plane, landmark, sight.blobs, hypothesis, noise_lsb);
  const double scale = 1.0 / (1 << level);
  Eigen::Matrix3d to_level = Eigen::Matrix3d::Identity();
  to_level(0, 0) = to_level(1, 1) = scale;
  to_level(0, 2) = (0.5 - area.x_px) * scale - 0.5;
  to_level(1, 2) = (0.5 - area.y_px) * scale - 0.5;
  return verify_landmark(sight.finder.picture_at(level), to_level * hypothesis.H_px_plane, landmark, sight.blobs,
                         hypothesis, noise_lsb);
}

void Detector::Workspace::note_refusal(const Hypothesis& hypothesis, const Verification& verification) noexcept {
  if (nearest && verification.score <= refused.score) return;
  nearest = hypothesis;
  refused = verification;
}

void Detector::Workspace::note_three(const Hypothesis& hypothesis, const Verification& verification) noexcept {
  if (!verification.has_three_dots || (three && verification.score <= three_verification.score)) return;
  three = hypothesis;
  three_verification = verification;
}

/// A dot that something hides in part has an outline all around all the same, but it is smaller than the others say.
bool Detector::Workspace::is_cut(const Hypothesis& hypothesis, std::size_t dot, const Blob& blob) const noexcept {
  const double radius_m = landmark.radius_m(dot);
  const double whole_px2 = std::numbers::pi * radius_m * radius_m *
                           jacobian_of_map(hypothesis.H_px_plane, landmark.centre_m(dot)).determinant();
  return static_cast<double>(blob.area_px2) < whole_px2 * (kCutShare - kOutlineSlack_px / std::sqrt(whole_px2));
}

Result<LandmarkObservation> Detector::Workspace::observe(const BlobList& blobs, const Accepted& from,
                                                         Numbering numbering) const noexcept {
  const Hypothesis& hypothesis = *from.hypothesis;
  LandmarkObservation seen;
  InlineVector<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    DotObservation& d = seen.dots[dot];
    d.visible_fraction = from.verification.visible_fraction[dot];
    if (hypothesis.blob[dot] < 0) continue;
    const Blob& blob = blobs[static_cast<std::size_t>(hypothesis.blob[dot])];
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
    if (const auto seen = w.observe(w.whole.blobs, accepted, Workspace::Numbering::kByPriors))
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

std::optional<LandmarkObservation> Detector::three_dots() const noexcept {
  const Workspace& w = *workspace_;
  if (!w.three) return std::nullopt;
  const auto seen = w.observe(w.whole.blobs, {&*w.three, w.three_verification}, Workspace::Numbering::kByPriors);
  return seen ? std::optional(*seen) : std::nullopt;
}

FailedSearch Detector::failed_search() const noexcept {
  const Workspace& w = *workspace_;
  FailedSearch failed;
  failed.spots = w.whole.blobs.span();
  failed.noise_lsb = w.whole.finder.noise_lsb();
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
