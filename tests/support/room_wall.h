#pragma once
/// A room with landmarks on its walls, and what light its sides send to a camera.
///
/// World: Z up; walls at the ends of X and Y.
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/support/colour_renderer.h"
#include "tests/support/renderer_cover.h"

namespace ninedot::test {

enum class RoomSide : std::uint8_t { kHighX, kLowX, kHighY, kLowY };

/// A landmark in its default size, upright on a wall.
struct HungLandmark {
  RoomSide side = RoomSide::kHighX;
  double along_m = 0;                ///< of P9: Y of the world on the walls at the ends of X, X on the others
  double height_m = 0;               ///< of P9: Z of the world
  std::array<LinearRgb, 9> discs{};  ///< P1..P9
  LinearRgb paper{0.84, 0.84, 0.84};
};

/// Something else that hangs there, of one colour; below the landmarks.
struct Poster {
  RoomSide side = RoomSide::kHighX;
  double along_m = 0, height_m = 0;  ///< of its middle
  double width_m = 0.5, tall_m = 0.5;
  LinearRgb colour;
};

/// Irradiance = ambient + strength cos(incidence) / (r^2 + softening), r the distance to the lamp.
struct Lamp {
  std::array<double, 3> position_m{0, 0, 2.5};
  double ambient = 0.85;
  double strength_m2 = 0;
  double softening_m2 = 1;
};

/// \param to_lamp_m  from the place that is lit \param normal  of the surface there; in the same frame, any
double irradiance(const Lamp& lamp, const Eigen::Vector3d& to_lamp_m, const Eigen::Vector3d& normal);

struct Room {
  std::array<double, 3> low_m{-4, -3, 0}, high_m{4, 3, 2.8};
  std::vector<HungLandmark> landmarks;
  std::vector<Poster> posters;
  Texture wall;  ///< of all six sides, each with another seed
  Lamp lamp;
  LinearRgb light;  ///< its colour, times the lamp's
};

/// P1..P8 in the inks of a code (K R G B), P9 black.
std::array<LinearRgb, 9> inks_of_code(std::string_view code);

/// Where a landmark's P9 is in the world [m].
Eigen::Vector3d place_of(const Room& room, const HungLandmark& landmark);
/// Its frame S0 in the world: columns X0 Y0 Z0.
Eigen::Matrix3d axes_of(RoomSide side);

/// One of the six sides of a room. Frame of a side: X and Z along it, Y into the room; of a wall the axes of S0.
class RoomWall {
 public:
  /// \param axis  0, 1, 2: X, Y or Z of the world is constant there \param high  it is the upper end
  RoomWall(const Room& room, int axis, bool high);

  Eigen::Vector3d turned(const Eigen::Vector3d& v_world) const { return R_side_world_ * v_world; }
  Eigen::Vector3d moved(const Eigen::Vector3d& p_world_m) const { return R_side_world_ * (p_world_m - origin_m_); }

  /// A flat thing on it.
  struct Mark {
    Eigen::Vector2d middle_m{0, 0};
    double half_width_m = 0, half_height_m = 0;
    bool round = false;  ///< a disc of radius half_width_m
    Eigen::Array3d reflectance{0, 0, 0};
    double reach_m = round ? half_width_m : std::hypot(half_width_m, half_height_m);  ///< no part is farther away
  };
  using Marks = std::vector<const Mark*>;

  /// Red, green and blue light that a whole cell sends to the camera. \param near  what is painted there, for
  /// `light_of_sample`
  Eigen::Array3d light_of_cell(Spot& spot, Marks& near) const;

  /// Light of a spot inside the cell.
  Eigen::Array3d light_of_sample(Spot& spot, const Marks& near) const;

 private:
  /// The wall's texture, worked out on a grid.
  class Pattern {
   public:
    Pattern(const Texture& texture, const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m);
    double at(const Eigen::Vector2d& at_m) const;

   private:
    double even_;
    Eigen::Vector2d low_m_;
    Eigen::ArrayXXd values_;  ///< empty: even
  };

  Eigen::Matrix3d R_side_world_;
  Eigen::Vector3d origin_m_;
  std::vector<std::vector<Mark>> things_;  ///< in the order of painting, first the one that holds the others
  Pattern pattern_;
  Lamp lamp_;
  Eigen::Vector3d lamp_m_;
  Eigen::Array3d tint_;
};

}  // namespace ninedot::test
