#pragma once
/// What the renderer's rays meet: paint on the wall, the board before it, the light on both.
#include <Eigen/Core>
#include <vector>

#include "tests/support/renderer.h"
#include "tests/support/renderer_cover.h"

namespace ninedot::test {

/// The scene, with everything that does not depend on the pixel worked out once. The scene must outlive it.
class Wall {
 public:
  explicit Wall(const Scene& scene);

  /// Where nothing is hit.
  double horizon() const { return scene_.light.level * scene_.wall.reflectance; }

  /// Light that a whole cell sends to the camera; remembers what is painted there for `light_of_sample`.
  double light_of_cell(Spot& spot);

  /// Light of a spot inside the last cell.
  double light_of_sample(Spot& spot) const;

 private:
  /// Paper, dot or stroke.
  struct Mark {
    Eigen::Vector2d middle_m{0, 0};
    double reach_m = 0;  ///< no part of it is farther from its middle
    double reflectance = 0;
    bool round = true;  ///< a disc of radius reach_m; else a rectangle
    Eigen::Vector2d along{1, 0};
    double half_length_m = 0, half_width_m = 0;

    double cover_at(Spot& spot) const;
  };
  static Mark rectangle(const Eigen::Vector2d& middle_m, const Eigen::Vector2d& along, double length_m, double width_m,
                        double reflectance);
  double reflectance_at(Spot& spot) const;
  double irradiance(Spot& spot) const;

  const Scene& scene_;
  std::vector<Mark> marks_;        ///< in the order of painting
  std::vector<const Mark*> near_;  ///< of the last cell
  Mark board_;
};

}  // namespace ninedot::test
