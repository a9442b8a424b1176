#pragma once
/// How much of a pixel a sheet's paper and dots cover.
#include <Eigen/Core>
#include <array>

namespace ninedot {

struct HungSheet;

/// A pixel's ray at z = 1, and how it changes from one pixel to the next [1].
struct PixelRay {
  Eigen::Vector2d at, per_column, per_row;
};

/// Sums over the moments of an exposure.
struct PixelCover {
  float paper = 0;               ///< share of the pixel that the sheet covers, its dots included [1]
  float ink = 0;                 ///< share that a dot covers [1]
  std::array<float, 3> light{};  ///< reflectance of that dot, red, green, blue, times its share [1]
};

/// One sheet as one row of pixels sees it at one moment. Memory: inside. Threads: one.
class PixelPainter {
 public:
  /// \param sheet  must outlive this \param plane_from_ray  maps a ray to (X, Z, 1) / (distance along z), [1/m]
  void begin(const HungSheet& sheet, const Eigen::Matrix3d& plane_from_ray) noexcept {
    sheet_ = &sheet;
    H_ = plane_from_ray;
  }

  /// Pixels that an edge crosses are looked at in 4 x 4 cells, in each of which the edge counts as straight: its area
  /// is right to a hundredth of a pixel for discs of 2 px and more. \param ray  not a number: nothing is there
  void add(const PixelRay& ray, PixelCover& cover) const noexcept;

 private:
  /// Where a ray meets the plane [m], and how that changes from pixel to pixel: columns, rows.
  struct Spot {
    Eigen::Vector2d at;
    Eigen::Matrix2d per_px;
  };
  struct Dot {
    int index = -1;  ///< none where below 0
    Eigen::Vector2d middle;
    double radius_m = 0;
    bool is_crossed = false;  ///< its edge may cross the pixel
  };
  bool hits(const PixelRay& ray, Spot& spot) const noexcept;
  Dot dot_near(const Spot& spot, double reach_m) const noexcept;
  void add_dot(const Dot& dot, float share, PixelCover& cover) const noexcept;
  void add_edges(const PixelRay& ray, const Spot& spot, const Dot& dot, PixelCover& cover) const noexcept;

  const HungSheet* sheet_ = nullptr;
  Eigen::Matrix3d H_;
};

}  // namespace ninedot
