#pragma once
/// The pose that fits the grey levels along all outlines best, from one start.
#include <array>
#include <cstdint>
#include <limits>

#include "geometry/dot_sighting.h"
#include "geometry/gauss_newton.h"
#include "image/image_view.h"
#include "pose/outline_pixels.h"
#include "pose/outline_sums.h"
#include "pose/outline_weights.h"
#include "pose/smeared_ink.h"

namespace ninedot {

/// One planar solution: the pixels along its outlines, what each group of them says, and the state that fits them.
/// Keeps nothing from one `refine` to the next. The last step's normal matrix is the information matrix.
/// Memory: the constructor's, about 0.6 MB. Threads: one caller.
class OutlineRefiner {
 public:
  /// \param rays  must outlive the refiner
  /// \param regards_walls  OutlinePixels::regards_walls
  OutlineRefiner(const CameraModel& camera, const LandmarkGeometry& landmark, const RayTable& rays,
                 bool regards_walls = false);

  /// How good a start is.
  enum class Start : std::uint8_t {
    kRough,     ///< outlines within about 2 px, blur unknown
    kClose,     ///< outlines within about half a pixel, blur and offset as in the frame before
    kExpected,  ///< the same, foretold and not seen: given up where they turn out to be further off
  };

  /// What the light of a picture is taken for.
  enum class Light : std::uint8_t {
    /// Small dots that a shadow's edge crosses are cut into sectors, each with light of its own, and a tone curve moves
    /// all outlines alike.
    kSimple,
    /// One straight edge is fitted with each of those dots, where that explains its light, and the tone curve bends the
    /// grey levels of a wide blur (tone.h).
    kFull,
  };

  /// \param warp_px  how far the dots may lie from where one flat sheet shows them, before any is an outlier
  /// \param pixels  how many pixels it may fit, each counted once per stage; fewer afterwards. Used up, it leads
  /// nowhere. \param light  what the picture's is taken for [1] \param hopeless_lsb  a residual that is above this
  /// after a few steps leads nowhere \return  how it went; unless it has converged the rest means nothing
  const OptimiserStatistics& refine(const ImageView& luma, const OutlineState& start, Start quality, double warp_px,
                                    int& pixels, Light light = Light::kSimple,
                                    double hopeless_lsb = std::numeric_limits<double>::infinity()) noexcept;

  /// How much worse `other` explains the pixels that this state was fitted to: difference of chi^2 [1].
  /// \param enough  where it is surely more than that, the answer may be anything in between [1]
  double chi2_above(const OutlineState& other, double enough = std::numeric_limits<double>::infinity()) const noexcept;

  /// Of a dot's groups, the share whose outline is where it belongs, though its light may be spoiled. 0..1
  std::array<double, kDotCount> visible_share() const noexcept;

  /// What each dot's outline alone says of where its middle is; all that the grey levels say of the pose, but for what
  /// the dots' sizes and shapes add (world/sighting.h says what for).
  DotSightings dots() const noexcept;

  /// Whether these are discs. Costs as much as a stage.
  OutlineShape shape() const noexcept;

  /// How many of the smaller dots a shadow's edge crosses: they were cut, or have an edge. 0..9
  int shadowed_dots() const noexcept;

  /// Whether an edge of light explains one of them at least.
  bool has_light_edges() const noexcept;

  /// Whether one of them is so wide that the light falls over a good part of its dot.
  bool has_penumbra() const noexcept;

  /// How far a tone curve is more than an offset of the outlines, as wide as their blur is. 0..1
  double tone_share() const noexcept;

  /// Whether the tone curve is one of the unknowns.
  bool has_tone() const noexcept { return pixels_.has_tone; }

  /// Of the ring's dots, seen from in front. [px]
  double dot_radius_px() const noexcept;

  const OutlineState& state() const noexcept { return state_; }
  const OptimiserStatistics& statistics() const noexcept { return statistics_; }
  /// Inverse covariance of the unknowns, all nuisances of the groups eliminated: [1/m^2] of the pose, [1/px^2] of the
  /// offset, [1/px^4] of the blur, mixed ones between them.
  const UnknownMatrix& information() const noexcept { return information_; }
  /// Root mean square of the groups' shifts against the state.
  double rms_px() const noexcept { return weights_.rms_px; }
  const OutlineFit& fit() const noexcept { return weights_.fit; }

  // What gauss_newton asks of a problem, and nobody else.
  using Step = UnknownVector;
  /// \param stage  index of the stage under way
  bool linearise(int stage) noexcept;
  /// \param stage  index of the stage under way \param step  [m] (pose), [px] (offset), [px^2] (blur), [1] (tone)
  StepVerdict solve(int stage, Step& step) noexcept;
  /// \param stage  index of the stage under way \param step  [m] (pose), [px] (offset), [px^2] (blur), [1] (tone)
  StepVerdict take(int stage, const Step& step) noexcept;

 private:
  /// Where the pixels at hand were collected, and what has happened since.
  struct Look {
    double band_px = 0, moved_px = 0;
    bool thinned = false, split_since = false;
  };
  void guess_tone() noexcept;
  bool look_again_if_stale(int stage) noexcept;
  void fit_groups(std::size_t every) noexcept;
  bool follow_shadows() noexcept;
  double semi_minor_px(std::size_t dot) const noexcept;
  bool solve_equations(double nuisance_sigma, Step& step) noexcept;
  bool is_first_of_expectation(int stage) const noexcept;
  bool is_blank() const noexcept;
  void apply(const Step& step) noexcept;
  void foretell_fits() noexcept;
  bool weigh_again(int stage) noexcept;
  /// Of a step's part that moves the pose: in units of the noise, and as a move of the outlines.
  double step_chi2(const Step& step) const noexcept;
  double step_px(const Step& step) const noexcept;

  CameraModel camera_;
  LandmarkGeometry landmark_;
  const RayTable& rays_;
  ToneBend usual_bend_;  ///< until the first fit tells each dot's light

  // Of the refinement under way.
  ImageView luma_;
  Start quality_ = Start::kRough;
  double warp_px_ = 0;
  int pixels_left_ = 0;
  Look look_;
  double last_step_px_ = 0;
  double hopeless_lsb_ = 0;
  double start_band_px_ = 0;           ///< of the state that refine() began with
  bool expectation_is_close_ = false;  // its first step was short: it may be the last

  OutlinePixels pixels_;
  DotContrasts contrasts_lsb_{};  // of each dot that is one group, by the last fit
  GroupFits fits_;
  OutlineWeights weights_;
  Cuts cuts_{};
  Light light_ = Light::kSimple;
  double tone_share_ = 0;  ///< of the state that refine() began with
  OutlineState state_, linearised_at_;
  UnknownVector last_step_ = UnknownVector::Zero();  // from there
  UnknownVector moved_ = UnknownVector::Zero();      // by it: blur and tone may have met their limits
  OptimiserStatistics statistics_;
  UnknownMatrix information_ = UnknownMatrix::Zero();
  // The last step's equations without the priors, and by how much chi^2 falls with it.
  UnknownMatrix of_pixels_ = UnknownMatrix::Zero();
  UnknownVector gradient_of_pixels_ = UnknownVector::Zero();
  double gain_ = 0;
};

}  // namespace ninedot
