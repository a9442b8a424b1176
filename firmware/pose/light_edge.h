#pragma once
/// A shadow's edge across a dot: light that falls from one level to another along a straight line, over some width.
#include <Eigen/Core>
#include <optional>
#include <span>

namespace ninedot {

/// The share of one light and not of the other is Phi((normal . pixel - offset) / width), Phi the normal distribution.
struct LightEdge {
  Eigen::Vector2d normal{1, 0};       ///< across it, in the picture [1]
  double offset_px = 0;               ///< along `normal`, from the middle of the picture's first pixel
  double width_px = 0;                ///< sigma of its profile: of penumbra and point spread together
  double paper_lsb = 0, ink_lsb = 0;  ///< by how much paper and ink are brighter beyond it than before it
  double moves_px = 0;       ///< by so much the outline may seem to be moved by what the edge is otherwise: 1 sigma
  double variance_lsb2 = 0;  ///< of the pixels about it
  double more_contrast = 0;  ///< by what share of the contrast before it that beyond it is larger, above -1
};

/// Pixels of a dot, all of the same length.
struct LitPixels {
  std::span<const float> x_px, y_px;
  std::span<const float> luma;       ///< grey levels [LSB]
  std::span<const float> ink_share;  ///< how much of a pixel is ink, 0..1
  /// Of a dot that is large beside its blur, from the outline outwards: how far, in sigmas of the blur, and the
  /// direction in the picture, as long as the sigma [px]. Of another one 0.
  std::span<const float> outside, outward_x_px, outward_y_px;
  double lit_ink;  ///< by how much ink's grey level changes where the light does, when paper's changes by 1
};
/// How far it may be from that: where hardly any ink lies beyond an edge, its level there would be anything. As scale
/// of a column with a ridge of a thousandth of a pixel: a tenth of the paper's change, which is 40 sigmas of noise.
inline constexpr double kInkOfItsOwn = 0.125;

/// How much of a pixel is ink and beyond an edge. Blurred together, the two are no product, as both lie about in the
/// same direction: it is the bivariate normal distribution, by its tetrachoric series (Pearson, "On the correlation of
/// characters not quantitatively measurable", Phil. Trans. R. Soc. A 195, 1900).
/// \param u  from the edge, in its widths \param outside  from the outline, in sigmas of the blur
/// \param densities  of the normal distribution there, multiplied
/// \param same_way  cosine between the outline's outward direction and the edge's, times blur over width, -1..1
template <typename Real>
Real ink_beyond(Real beyond, Real ink, Real u, Real outside, Real densities, Real same_way) noexcept {
  const Real r = -same_way, v = -outside;
  return beyond * ink + densities * r * (1 + r * (u * v / 2 + r * (u * u - 1) * (v * v - 1) / 6));
}

/// The edge that explains a dot's grey levels best, beside four of its own: of paper and ink, on either side.
/// \param start  where the search begins; without one, everywhere across the dot
/// \return  none: no edge, one that leaves the dot, or one beyond which no dot is in sight, which hides it
/// Memory: none. Threads: pure. Source: Gauss-Newton over place, direction and width, the levels eliminated.
std::optional<LightEdge> find_light_edge(const LitPixels& pixels, const LightEdge* start) noexcept;

}  // namespace ninedot
