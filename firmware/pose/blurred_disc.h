#pragma once
/// The picture of a dot through a blur that is not small beside it.
///
/// Where the outline bends within the blur's reach, no profile across it says what a pixel sees: at two sigmas across
/// a profile is off by a third of the contrast in the dot's middle, and where motion blurs one way, by as much as the
/// sheet's tilt shortens the dots. A Gaussian blur of a disc is an integral along its outline instead (Green's theorem;
/// d from the pixel to the outline, in sigmas of the blur):
///     share(p) = 1/2pi  closed integral of (1 - exp(-|d|^2 / 2)) / |d|^2  (d x dd)
/// and moving the outline by m adds 1/2pi exp(-|d|^2 / 2) (m x dd) for each of its parts. Both integrands are smooth
/// and periodic, so that a few nodes do (Trefethen & Weideman, "The exponentially convergent trapezoidal rule", SIAM
/// Review 56, 2014).
///
/// Motion draws a line of each point, which is no Gaussian: the outline's nodes are there once for each part of the
/// smear (Smear). More of the blur's harmonic is a longer line there, or one that is turned: its parts move. (Taken for
/// more of a Gaussian, which blurs the line's ends and leaves them where they are, it led steps astray from 8 px on.)
///
/// The outlines' common offset moves the nodes and leaves their parts as long as they are: by what a disc has shrunk,
/// its ink is more than whole inside. Contrast is each group's own and takes that out again; a dot's contrast stays
/// what a tone curve, which makes the offset, has left of it. Where the curve is fitted (OutlinePixels::has_tone) the
/// offset is ink that has spread: parts grow with the outline, and no share is above one.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>

#include "geometry/landmark.h"
#include "pose/outline_pixels.h"
#include "pose/outline_state.h"

namespace ninedot {

inline constexpr std::size_t kLanes = 8;  ///< pixels at a time: loops over lanes become vector instructions
using Lanes = std::array<float, kLanes>;

/// What is asked of a group: nothing but residuals, contrast and paper; or also what moves its outline: the unknowns of
/// the state, or in place of those of the pose and the offset the shape of its dot (outline_shape.h).
enum class Asked : std::uint8_t { kLightOnly, kState, kShape };

/// Columns that move an outline: those of pose and offset, or those of its shape; the blur's come after them.
inline constexpr std::size_t kMoveColumns = 7, kBlurColumns = 3;

/// A dot's outline as nodes, in sigmas of the blur.
/// Memory: none but itself. Threads: pure.
class BlurredDisc {
 public:
  /// \param asked  kLightOnly: the nodes have no moves
  BlurredDisc(const OutlinePixels& pixels, const LandmarkGeometry& landmark, const OutlineState& state, std::size_t dot,
              Asked asked) noexcept;

  /// It is small enough beside its blur to be taken as a whole; else nothing else of it is valid.
  bool is_small() const noexcept { return count_ > 0; }

  /// Whether any of these pixels may see its ink. \param ray_x  of the pixels, at z = 1 [1] \param ray_y  likewise [1]
  bool reaches_any(const Lanes& ray_x, const Lanes& ray_y) const noexcept;

  /// \param ray_x  of the pixels, at z = 1 [1] \param ray_y  likewise [1] \param share  of each pixel that is ink, 0..1
  /// [1]
  void ink_share(const Lanes& ray_x, const Lanes& ray_y, Lanes& share) const noexcept;

  /// The same, with how the grey level changes for contrast 1.
  /// \param ray_x  likewise [1] \param ray_y  likewise [1]
  /// \param by_moves  by what moves the outline [1/m] (pose), [1/px] (offset, shape)
  /// \param by_blur  its mean and second harmonic [1/px^2] \pre not kLightOnly
  void ink_share(const Lanes& ray_x, const Lanes& ray_y, Lanes& share, std::array<Lanes, kMoveColumns>& by_moves,
                 std::array<Lanes, kBlurColumns>& by_blur) const noexcept;

  /// By the blur alone.
  /// \param ray_x  likewise [1] \param ray_y  likewise [1] \param by_blur  likewise [1/px^2] \pre not kLightOnly
  void ink_by_blur(const Lanes& ray_x, const Lanes& ray_y, std::array<Lanes, kBlurColumns>& by_blur) const noexcept;

 private:
  static constexpr std::size_t kMostNodes = 26;     ///< of an outline
  static constexpr std::size_t kSmearedNodes = 16;  ///< of one that is there once for each part of a smear
  /// A point of the outline, with the part of it for which it stands.
  struct Node {
    float x, y;                             ///< [sigma]
    float part_x, part_y;                   ///< [sigma], over 4 pi
    std::array<float, kMoveColumns> moves;  ///< the area that each sweeps [sigma^2 per unit], over 2 pi
    std::array<float, kBlurColumns> blur_x, blur_y;
    float longer,
        turned;  ///< the area that it sweeps where the smear's line is longer, or turned, by a pixel, over 2 pi
  };
  template <bool kWithShare, bool kWithMoves, bool kWithBlur, bool kWithLine>
  void sum_up(const Lanes& ray_x, const Lanes& ray_y, Lanes* share, std::array<Lanes, kMoveColumns>* by_moves,
              std::array<Lanes, kBlurColumns>* by_blur) const noexcept;

  void smear_nodes(const Smear& smear, const Eigen::Vector2f& from_part_to_part) noexcept;

  std::size_t count_ = 0;
  /// What a unit of the blur's harmonic makes of a smear: how much longer its line is, and turned aside at its end
  /// [1/px]; and how much more blurred, all ways and by their own harmonic, its parts are [1].
  struct ByHarmonic {
    float longer, turned, mean, harmonic;
  };
  std::array<ByHarmonic, kBlurColumns - 1> by_harmonic_;  ///< along x and along the diagonal
  bool is_line_ = false;                                  ///< a smear of several parts; else by_harmonic_ is not valid
  Eigen::Vector2f middle_ray_;                            ///< of the dot
  Eigen::Matrix2f sigma_per_ray_;                         ///< what a ray beside that one is in sigmas of the blur
  Eigen::Vector2f reach_;                                 ///< of its nodes from the middle, along either axis [sigma]
  static constexpr std::size_t kMostNodesOfAll = std::max(kMostNodes, Smear::kMostParts* kSmearedNodes);
  std::array<Node, kMostNodesOfAll> nodes_;
};

}  // namespace ninedot
