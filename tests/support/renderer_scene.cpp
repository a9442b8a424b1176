// Viewpoints, sheets and boards: everything about a scene that is decided before a ray is cast.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/contract.h"
#include "tests/support/random.h"
#include "tests/support/renderer.h"

namespace ninedot::test {

CameraPose look_at_landmark(const Viewpoint& view) {
  EXPECTS(view.distance_m > 0 && std::abs(view.tilt_rad) < std::numbers::pi / 2);
  const Eigen::Vector3d centre =
      view.distance_m * Eigen::Vector3d(std::sin(view.tilt_rad) * std::cos(view.azimuth_rad), std::cos(view.tilt_rad),
                                        std::sin(view.tilt_rad) * std::sin(view.azimuth_rad));
  const Eigen::Vector3d z = -centre.normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d straight;
  straight << x, z.cross(x), z;
  const Eigen::Vector3d seen_at(std::tan(view.off_axis_x_rad), std::tan(view.off_axis_y_rad), 1);
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(seen_at, Eigen::Vector3d::UnitZ());
  Eigen::Quaterniond q(straight * Eigen::AngleAxisd(view.roll_rad, Eigen::Vector3d::UnitZ()) * turn);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return {{centre.x(), centre.y(), centre.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

Sheet nine_dot_sheet(double ring_radius_m, double dot_radius_m, double centre_radius_m) {
  Sheet sheet;
  for (int dot = 0; dot < 8; ++dot) {
    const double a_rad = dot * std::numbers::pi / 4;
    sheet.discs.push_back({ring_radius_m * std::sin(a_rad), -ring_radius_m * std::cos(a_rad), dot_radius_m});
  }
  sheet.discs.push_back({0, 0, centre_radius_m});
  return sheet;
}

Sheet square_dot_sheet() {
  Sheet sheet = nine_dot_sheet();
  for (const Disc& disc : sheet.discs) {
    const double half_m = 0.5 * std::sqrt(std::numbers::pi) * disc.radius_m;
    sheet.bars.push_back({disc.x_m - half_m, disc.z_m, disc.x_m + half_m, disc.z_m, 2 * half_m});
  }
  sheet.discs.clear();
  return sheet;
}

Sheet dot_ring_sheet(int dots, bool with_centre, double centre_radius_m) {
  Sheet sheet;
  for (int dot = 0; dot < dots; ++dot) {
    const double a_rad = dot * 2 * std::numbers::pi / dots;
    sheet.discs.push_back({0.080 * std::sin(a_rad), -0.080 * std::cos(a_rad), 0.0127});
  }
  if (with_centre) sheet.discs.push_back({0, 0, centre_radius_m});
  return sheet;
}

Sheet dot_grid_sheet(int columns, int rows, double pitch_m, double dot_radius_m) {
  Sheet sheet;
  sheet.width_m = (columns + 1) * pitch_m, sheet.height_m = (rows + 1) * pitch_m;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      sheet.discs.push_back(
          {(column - (columns - 1) / 2.0) * pitch_m, (row - (rows - 1) / 2.0) * pitch_m, dot_radius_m});
  return sheet;
}

Sheet clock_sheet(double radius_m) {
  Sheet sheet;
  sheet.width_m = sheet.height_m = 0;
  sheet.discs = {{0, 0, radius_m, 0.06}, {0, 0, 0.9 * radius_m, 0.88}};
  for (int hour = 0; hour < 12; ++hour) {
    const double a_rad = hour * std::numbers::pi / 6;
    sheet.discs.push_back({0.74 * radius_m * std::sin(a_rad), 0.74 * radius_m * std::cos(a_rad), 0.07 * radius_m});
  }
  sheet.bars = {{0, 0, 0.42 * radius_m, 0.2 * radius_m, 0.07 * radius_m},
                {0, 0, -0.5 * radius_m, 0.4 * radius_m, 0.05 * radius_m}};
  return sheet;
}

Sheet polka_dots(int count, double extent_m, double min_radius_m, double max_radius_m, std::uint64_t seed) {
  Random random(seed);
  Sheet sheet;
  sheet.width_m = sheet.height_m = 0;
  for (int i = 0; i < count; ++i) {
    const double x_m = random.uniform(-extent_m, extent_m), z_m = random.uniform(-extent_m, extent_m);
    sheet.discs.push_back({x_m, z_m, random.uniform(min_radius_m, max_radius_m), random.uniform(0.03, 0.25)});
  }
  return sheet;
}

double Relief::height_m(double x_m, double z_m) const {
  double sum_m = offset_m + slope_x * x_m + slope_z * z_m;
  for (const Wave& wave : waves) {
    const double along_m = std::cos(wave.direction_rad) * x_m + std::sin(wave.direction_rad) * z_m;
    sum_m += wave.height_m * std::sin(2 * std::numbers::pi * along_m / wave.length_m + wave.phase_rad);
  }
  return sum_m;
}

double board_offset_m(const Board& board, const Sheet& sheet) {
  EXPECTS(board.hidden_fraction >= 0 && board.hidden_fraction <= 1);
  const double c = std::cos(board.direction_rad), s = std::sin(board.direction_rad);
  // Length of the sheet across the edge's direction = convolution of two boxes: its area beyond `offset` is a
  // piecewise quadratic. Bisection on a fine sum is simpler and good to a thousandth of a millimetre.
  const double a_m = sheet.width_m / 2 * std::abs(c), b_m = sheet.height_m / 2 * std::abs(s);
  const double wide_m = std::max(a_m, b_m), narrow_m = std::min(a_m, b_m);
  const auto hidden = [&](double offset_m) {
    constexpr int kSlices = 512;
    double sum = 0;
    for (int i = 0; i < kSlices; ++i) {
      const double slice_m = narrow_m * (2 * (i + 0.5) / kSlices - 1);
      sum += std::clamp((wide_m - (offset_m - slice_m)) / (2 * wide_m), 0.0, 1.0);
    }
    return sum / kSlices;
  };
  double low_m = -(a_m + b_m), high_m = a_m + b_m;
  for (int i = 0; i < 50; ++i) {
    const double middle_m = (low_m + high_m) / 2;
    (hidden(middle_m) > board.hidden_fraction ? low_m : high_m) = middle_m;
  }
  return sheet.x_m * c + sheet.z_m * s + (low_m + high_m) / 2;
}

}  // namespace ninedot::test
