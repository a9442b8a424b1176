#pragma once
/// Residuals and Jacobian of the pixels along one outline, eight pixels at a time.
///
/// METHOD, section 3: I = paper + (ink - paper) Phi(-d / s), d the signed distance to a projected disc's outline [px].
/// Unknown everywhere: six of pose, a common offset of all outlines (tone curves), three of the blur (it may be wider
/// in one direction: motion). Unknown in each group: paper, ink, what lies beyond the paper, the light's slope, and of
/// a colour camera how its pattern changes the blur from pixel to pixel; these are linear, and outline_sums.h
/// eliminates them.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/inline_vector.h"
#include "pose/blurred_disc.h"
#include "pose/outline_pixels.h"
#include "pose/outline_state.h"

namespace ninedot {

/// The columns: the pattern's [1/px^2]; the unknowns' derivatives for contrast 1 [1/m] (pose), [1/px]
/// (offset), [1/px^2] (blur); the grey level [LSB]; then the light's [1], so that a group without the last ones ends
/// earlier.
inline constexpr std::size_t kPatternColumns = 4;
/// The tone's comes first: where it is none of the unknowns, nobody begins with it.
inline constexpr std::size_t kToneColumn = kPatternColumns, kStateColumn = kToneColumn + 1,
                             kGreyColumn = kStateColumn + kToneUnknown;
inline constexpr std::size_t kPaperColumn = kGreyColumn + 1, kInkColumn = kGreyColumn + 2,
                             kBeyondColumn = kGreyColumn + 3, kSlopeXColumn = kGreyColumn + 4,
                             kSlopeYColumn = kGreyColumn + 5;
/// Of a small dot beside a side of the sheet: by how much what lies beyond changes along it, per radius of the dot.
inline constexpr std::size_t kBeyondAlongColumn = kGreyColumn + 6;
/// Of a dot that a shadow's edge crosses: how much brighter paper, and ink with it, is beyond it, and how much ink is
/// by itself, in place of the slopes; then the edge's own: its place, direction and width.
inline constexpr std::size_t kBeyondEdgeColumn = kSlopeXColumn, kInkBeyondEdgeColumn = kSlopeYColumn,
                             kEdgePlaceColumn = kGreyColumn + 6, kEdgeTurnColumn = kGreyColumn + 7,
                             kEdgeWidthColumn = kGreyColumn + 8;
inline constexpr std::size_t kColumns = kGreyColumn + 9;
using OutlineColumns = std::array<Lanes, kColumns>;
/// So many are filled at a time: a small dot's pixels are through in one go, and the buffer stays in the nearest cache.
inline constexpr std::size_t kMaxBatches = 16;
using ColumnBatches = std::array<OutlineColumns, kMaxBatches>;

/// What all pixels of a dot share, at one state.
/// A blur's variance by its direction: OutlineState's. [px^2]
struct BlurShape {
  float mean_px2, cos_px2, sin_px2;
};

struct DotView {
  DotView(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state, std::size_t dot);

  Eigen::Vector3f rX, rZ;         ///< the sheet's axes [1], frame camera
  Eigen::Vector3f inverse_depth;  ///< its product with a ray (z = 1) is 1 / depth of the sheet there [1/m]
  float per_height;               ///< 1 / distance of the sheet's plane, signed [1/m]
  Eigen::Vector2f origin;         ///< the sheet's origin along its axes [m], seen from the camera
  Eigen::Vector2f middle;         ///< the dot's middle, likewise [m]
  /// Where a ray m meets the sheet is depth (by_ray_X . (m - near_ray) + left_X) along X from that middle, and likewise
  /// along Z. Places from the sheet's origin would be rounded by 1e-5 px, all pixels of a dot alike.
  Eigen::Vector2f near_ray;            ///< of the middle, rounded [1]
  Eigen::Vector2f by_ray_X, by_ray_Z;  ///< [1]
  float left_X, left_Z;                ///< of near_ray, as it is rounded [1]
  Eigen::Vector2f px_X, px_Z, px_n;  ///< change of a ray per pixel along the sheet's axes, and along its normal [1/px]
  /// Where what lies beyond the white begins, along the sheet's axes: unit vectors, square to them at the paper's
  /// radius [1]. P9 has none, most dots one; a dot on a diagonal that sees two of the square's sides has both.
  InlineVector<Eigen::Vector2f, 2> beyond;
  Eigen::Vector2f outward;  ///< from P9, along the sheet's axes [1]; 0 of P9
  float radius_m, paper_radius_m;
  float bend;  ///< what the outline's curvature times (slope / depth)^3 is, over depth^3 [1/m^3 px^2]
  BlurShape blur;
  BlurShape part_blur;           ///< of each part of a Smear
  float parts;                   ///< how many it has; 1: it is none
  Eigen::Vector2f part_line_px;  ///< from one part's middle to the next one's
  float offset_px;
  float side_offset_px;  ///< the sheet's sides are this much further out than at the paper's radius
  float ink_by_wall;     ///< by this share of what lies beyond in a pixel its ink is darker
  float ink_share;       ///< OutlinePixels::ink_share
  bool has_tone;         ///< OutlinePixels::has_tone
  float tone;            ///< OutlineState::tone [1]
  ToneBend tone_bend;    ///< OutlinePixels::tone_bends [1]
};

/// Some pixels of a group.
struct PixelRange {
  std::size_t first = 0;  ///< index of the first [1]
  std::size_t count = 0;  ///< how many, 1..kLanes * kMaxBatches
  std::size_t every = 1;  ///< 1: one after the other, 2: every second one, ... [1]
};

/// Evaluates some pixels of a group, kLanes to a batch; lanes beyond the last are zero. Grey levels are less the
/// group's first one: sums of squares stay small. The pose's unknowns are along the axes of the sheet: X, normal, Z
/// (they are the columns of `T_camera_landmark.rotation`), where they are cheapest. \param asked  kLightOnly: without
/// those of the state. kShape: those of pose and offset say how the grey levels change when the
/// outline moves out by h(angle) [px], where h is each of 1, cos, sin of the angle on the sheet, of twice and of four
/// times the angle [1/px]. Memory: none. Threads: pure.
void fill_columns(const OutlinePixels& pixels, const OutlineGroup& group, const DotView& view, const BlurredDisc& disc,
                  PixelRange range, Asked asked, ColumnBatches& batches) noexcept;

/// From the outline of a dot outwards: how far, in sigmas of the blur, and which way, as long as a sigma [px]. A batch
/// each; `range` takes every pixel. \param outside  [1]. Memory: none. Threads: pure.
void look_outward(const OutlinePixels& pixels, const DotView& view, PixelRange range, std::span<Lanes> outside,
                  std::span<Lanes> x_px, std::span<Lanes> y_px) noexcept;

/// Fills the columns of a colour camera's pattern, and no others. Interpolation blurs each colour most where it is not
/// seen: by half a pixel squared more or less, all ways where red and blue are, along or across where green is, at
/// every second column and row. What that is of luma depends on the ink. So the columns say how the grey levels change
/// with a blur that is wider at even columns of the picture than at odd ones, likewise at rows, and the same of its
/// second harmonic along the picture's axes.
/// \param view  of before_interpolation() \param disc  likewise, not kLightOnly
/// Memory: none. Threads: pure.
void fill_pattern_columns(const OutlinePixels& pixels, const DotView& view, const BlurredDisc& disc, PixelRange range,
                          ColumnBatches& batches) noexcept;

}  // namespace ninedot
