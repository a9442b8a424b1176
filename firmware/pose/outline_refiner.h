#pragma once
/// Gauss-Newton on the grey levels along all outlines, from one start.
#include <array>
#include <cstdint>

#include "image/image_view.h"
#include "pose/outline_model.h"

namespace ninedot {

/// One planar solution: the pixels along its outlines, what each group of them says, and the state that fits them.
///
/// Groups whose outline is not where the others say, or that show no outline at all (hidden, cut by a shadow), lose
/// their weight (iteratively reweighted least squares; Geman & McClure's weight). The last step's normal matrix is the
/// information matrix.
/// Memory: the constructor's. Threads: one caller.
class OutlineRefiner {
 public:
  /// \param rays  must outlive the refiner
  OutlineRefiner(const CameraModel& camera, const LandmarkGeometry& landmark, const RayTable& rays);

  /// How good a start is.
  enum class Start : std::uint8_t {
    kRough,     ///< outlines within about 2 px, blur unknown
    kClose,     ///< outlines within about half a pixel, blur and offset as in the frame before
    kExpected,  ///< the same, foretold and not seen: given up where they turn out to be further off
  };

  /// \param warp_px  how far the dots may lie from where one flat sheet shows them, before any is an outlier
  /// \return  false when the visible outlines determine nothing; then the rest means nothing
  bool refine(const ImageView& luma, const OutlineState& start, Start quality, double warp_px) noexcept;

  /// How much worse `other` explains the pixels that this state was fitted to, in units of the noise.
  double chi2_above(const OutlineState& other) const noexcept;

  /// Of a dot's groups, the share whose outline is where it belongs, though its light may be spoiled.
  std::array<double, kDotCount> visible_share() const noexcept;

  /// Every dot was taken whole, or is large: no shadow's edge crosses the landmark.
  bool is_light_smooth() const noexcept;

  const OutlineState& state() const noexcept { return state_; }
  /// Inverse covariance of the unknowns, all nuisances of the groups eliminated.
  const UnknownMatrix& information() const noexcept { return information_; }
  /// Root mean square of the groups' shifts against the state.
  double rms_px() const noexcept { return rms_px_; }

 private:
  void collect(const ImageView& luma, double band_px, int thinning) noexcept;
  void weigh_groups(double shift_floor_px) noexcept;
  double model_variance_px2(double contrast_lsb) const noexcept;
  bool split_shadowed_dots() noexcept;
  bool solve_step(double nuisance_sigma, UnknownVector& step) noexcept;
  /// Of a step's part that moves the pose: in units of the noise, and as a move of the outlines.
  double step_chi2(const UnknownVector& step) const noexcept;
  double step_px(const UnknownVector& step) const noexcept;

  CameraModel camera_;
  LandmarkGeometry landmark_;
  const RayTable& rays_;
  OutlinePixels pixels_;
  std::array<GroupFit, kMaxGroups> fits_;
  std::array<double, kMaxGroups> weight_{};       // in the normal equations
  std::array<bool, kMaxGroups> outline_there_{};  // an outline where it belongs, though its light may be spoiled
  std::array<bool, kDotCount> split_{};  // dots whose light is not smooth: cut into sectors although they are small
  OutlineState state_;
  UnknownMatrix information_ = UnknownMatrix::Zero();
  double noise_variance_ = 1;  // LSB^2
  double rms_px_ = 0;
};

}  // namespace ninedot
