#pragma once
/// What one group of pixels says of the unknowns, once its own light is fitted as well as it can be.
///
/// Paper, ink, what lies beyond the paper and the slopes are linear and belong to one group: they are eliminated group
/// by group (Golub & Pereyra, "The differentiation of pseudo-inverses and nonlinear least squares problems whose
/// variables separate", SIAM J. Numer. Anal. 10, 1973).
#include <optional>

#include "pose/outline_columns.h"

namespace ninedot {

/// What one group says.
struct GroupFit {
  bool usable = false;
  double squared_residuals = 0;  ///< [LSB^2]
  double shift_px = 0;           ///< by how much its outline lies further out than the state says
  double shift_information = 0;  ///< inverse variance of shift_px, times the noise's variance [LSB^2 / px^2]
  double light_px2 = 0;          ///< variance of shift_px by what the model of its light leaves
  double contrast_lsb = 0, paper_lsb = 0;
  int degrees_of_freedom = 0;
  /// J^T J with the group's own unknowns eliminated, per square of the unknowns' units: [LSB^2/m^2] of the pose along
  /// the sheet's axes (outline_columns.h), [LSB^2/px^2] of the offset, [LSB^2/px^4] of the blur, mixed ones between
  /// them.
  UnknownMatrix normal;
  /// J^T r, likewise, per unknown's unit: [LSB^2/m], [LSB^2/px], [LSB^2/px^2].
  UnknownVector gradient;
};

/// Evaluates groups at one state. What the groups of a dot share is worked out once, where they come one after another.
/// Memory: none but itself. Threads: not safe.
class GroupFitter {
 public:
  /// All of them have to outlive it.
  GroupFitter(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state,
              Asked asked) noexcept
      : pixels_(pixels), landmark_(landmark), state_(state), asked_(asked) {}

  /// \param every  1: all of its pixels, 2: every second one, ...
  void fit(const OutlineGroup& group, GroupFit& fit, std::size_t every = 1) noexcept;

  /// The shadow's edge that crosses a dot which is one group, outline and blur being as the state says.
  /// \param start  where it was, if it is known \return  none: no such edge
  std::optional<LightEdge> find_edge(const OutlineGroup& group, const LightEdge* start) noexcept;

 private:
  /// What a dot's groups share.
  struct Look {
    Look(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state, std::size_t dot,
         Asked asked) noexcept
        : view(pixels, landmark, state, dot), disc(pixels, landmark, state, dot, asked) {}
    DotView view;
    BlurredDisc disc;
  };
  void look_at(const OutlineGroup& group) noexcept;

  const OutlinePixels& pixels_;
  const LandmarkGeometry& landmark_;
  const OutlineState& state_;
  Asked asked_;
  std::size_t dot_ = kDotCount;  // that was looked at
  std::optional<Look> look_;
  std::optional<Look> before_interpolation_;  // of a picture with a pattern
};

}  // namespace ninedot
