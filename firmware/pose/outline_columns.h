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

/// The columns: the unknowns' derivatives for contrast 1 [1/m] (pose), [1/px] (offset), [1/px^2] (blur); the grey level
/// [LSB]; then the group's own [1], so that a group without the last ones ends earlier.
inline constexpr std::size_t kGreyColumn = kUnknowns;
inline constexpr std::size_t kPaperColumn = kUnknowns + 1, kInkColumn = kUnknowns + 2, kBeyondColumn = kUnknowns + 3,
                             kSlopeXColumn = kUnknowns + 4, kSlopeYColumn = kUnknowns + 5;
inline constexpr std::size_t kColumns = kUnknowns + 6;
using OutlineColumns = std::array<Lanes, kColumns>;
/// So many are filled at a time: a small dot's pixels are through in one go, and the buffer stays in the nearest cache.
inline constexpr std::size_t kMaxBatches = 8;
using ColumnBatches = std::array<OutlineColumns, kMaxBatches>;

/// What all pixels of a dot share, at one state.
struct DotView {
  DotView(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state, std::size_t dot);

  Eigen::Matrix3f F;             ///< sheet [m] from ray
  Eigen::Vector3f rX, rZ, n, t;  ///< the sheet's axes and its normal [1], and its origin [m], frame camera
  Eigen::Matrix2f N;             ///< ray (z = 1) per pixel [1/px]
  Eigen::Vector2f C;             ///< the dot's middle on the sheet [m]
  Eigen::Vector2f outward;  ///< unit vector from the landmark's middle through the dot's; the centre dot has none (0)
  float radius_m, paper_radius_m;
  float det_F;  ///< determinant of F [1/m]
  float det_N;  ///< determinant of N [1/px^2]
  float blur_px2, blur_cos_px2, blur_sin_px2, offset_px;
};

/// Evaluates the pixels [begin, begin + used) of a group, kLanes to a batch; lanes beyond `used` are zero. Grey levels
/// are less the group's first one: sums of squares stay small.
/// \param begin  index in the group of the first pixel [1] \param used  1..kLanes * kMaxBatches
/// Memory: none. Threads: pure.
void fill_columns(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& view, std::int32_t begin,
                  std::size_t used, ColumnBatches& batches) noexcept;

/// Puts the shape of the dot in place of the pose and the offset: how the grey levels change when its outline moves out
/// by h(angle) [px] where h is each of 1, cos, sin of the angle on the sheet, of twice and of four times the angle
/// [1/px].
/// \param begin  index in the group of the first pixel [1] \param used  1..kLanes * kMaxBatches
/// \param batches  as fill_columns left them, of the same pixels
/// Memory: none. Threads: pure.
void turn_to_shape(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& view, std::int32_t begin,
                   std::size_t used, ColumnBatches& batches) noexcept;

}  // namespace ninedot
