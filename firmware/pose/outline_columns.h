#pragma once
/// Residuals and Jacobian of the pixels along one outline, eight pixels at a time.
///
/// METHOD, section 3: I = paper + (ink - paper) Phi(-d / s), d the signed distance to a projected disc's outline [px].
/// Unknown everywhere: six of pose, a common offset of all outlines (tone curves), three of the blur (it may be wider
/// in one direction: motion). Unknown in each group: paper, ink, what lies beyond the paper, and the paper's slope;
/// these are linear, and outline_sums.h eliminates them.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "pose/outline_pixels.h"
#include "pose/outline_state.h"

namespace ninedot {

inline constexpr std::size_t kLanes = 8;  ///< pixels at a time: loops over lanes become vector instructions
using Lanes = std::array<float, kLanes>;

/// The columns: the unknowns' derivatives for contrast 1, the grey level, then the group's own, so that a group without
/// the last ones ends earlier.
inline constexpr std::size_t kGreyColumn = kUnknowns;
inline constexpr std::size_t kPaperColumn = kUnknowns + 1, kInkColumn = kUnknowns + 2, kBeyondColumn = kUnknowns + 3,
                             kSlopeXColumn = kUnknowns + 4, kSlopeYColumn = kUnknowns + 5;
inline constexpr std::size_t kColumns = kUnknowns + 6;
using OutlineColumns = std::array<Lanes, kColumns>;

/// What all pixels of a dot share, at one state.
struct DotView {
  DotView(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state, std::size_t dot);

  Eigen::Matrix3f F;             ///< sheet [m] from ray
  Eigen::Vector3f rX, rZ, n, t;  ///< the sheet's axes, its normal and origin [m], frame camera
  Eigen::Matrix2f N;             ///< ray per pixel
  Eigen::Vector2f C;             ///< the dot's middle [m, sheet]
  Eigen::Vector2f outward;       ///< from the landmark's middle through the dot's; of no use for the centre dot
  float radius_m, paper_radius_m, det_F, det_N;
  float blur_px2, blur_cos_px2, blur_sin_px2, offset_px;
};

/// Evaluates the pixels [begin, begin + used) of a group; lanes beyond `used` are zero. Grey levels are less the
/// group's first one: sums of squares stay small. \param used  1..kLanes
/// Memory: none. Threads: pure.
void fill_columns(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& view, std::int32_t begin,
                  std::size_t used, OutlineColumns& columns) noexcept;

}  // namespace ninedot
