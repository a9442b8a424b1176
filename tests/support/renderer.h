#pragma once
/// Pictures of the landmark made from geometry and light alone, with exact ground truth: for tests and accuracy tables.
///
/// It shares no projection code with the estimator (firmware/geometry), on purpose: a mistake in one would otherwise
/// be invisible in the other. Every ray is cast from the pixel to the wall; nothing is projected forwards.
///
/// Two stages, so that a bench can draw many noises from one exposure: `expose` (geometry, light, point spread, all in
/// linear light) and `read_out` (noise, tone curve, 8 bits). Frames and units: landmark frame S0 and camera frame as
/// everywhere in the project; metres, radians, pixels; light is linear and 1 saturates the sensor.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/image_view.h"

namespace ninedot::test {

enum class LensModel : std::uint8_t {
  kPlumbBob,     ///< k1 k2 p1 p2 k3
  kRational,     ///< k1 k2 p1 p2 k3 k4 k5 k6
  kEquidistant,  ///< k1 k2 k3 k4 (fisheye)
};

struct Lens {
  int width_px = 640, height_px = 480;
  double fx_px = 720, fy_px = 720, cx_px = 319.5, cy_px = 239.5;
  LensModel model = LensModel::kPlumbBob;
  std::array<double, 8> k{};  ///< in the model's own order, unused ones 0
};

/// Optical centre in S0 and the unit quaternion that rotates camera vectors into S0. Default: 1 m straight in front.
struct CameraPose {
  std::array<double, 3> position_m{0, 1, 0};
  std::array<double, 4> quaternion_wxyz{0, 0, 0.70710678118654752, -0.70710678118654752};
};

/// Where a camera stands and looks, in words that an accuracy table uses.
struct Viewpoint {
  double distance_m = 1;      ///< from the middle of P9
  double tilt_rad = 0;        ///< between the line of sight to P9 and the sheet's normal, [0, pi/2)
  double azimuth_rad = 0;     ///< side it is tilted to: 0 = X0 (the viewer's left), pi/2 = Z0 (above)
  double roll_rad = 0;        ///< of the camera about its axis; positive turns the picture's content counter-clockwise
  double off_axis_x_rad = 0;  ///< P9 appears to the right of the optical axis by this angle
  double off_axis_y_rad = 0;  ///< and below it by this one
};
CameraPose look_at_landmark(const Viewpoint& viewpoint);

/// A spot of another reflectance, in the sheet's coordinates.
struct Disc {
  double x_m = 0, z_m = 0;
  double radius_m = 0;
  double reflectance = 0.04;
};

/// A straight stroke with square ends, in the sheet's coordinates.
struct Bar {
  double x0_m = 0, z0_m = 0, x1_m = 0, z1_m = 0;
  double width_m = 0;
  double reflectance = 0.04;
};

/// Something flat on the wall Y0 = 0. Painted in order: paper, discs, bars.
struct Sheet {
  double x_m = 0, z_m = 0;                   ///< its middle, in S0
  double width_m = 0.210, height_m = 0.210;  ///< 0 = no paper, the marks are on the wall itself
  double reflectance = 0.90;
  std::vector<Disc> discs;
  std::vector<Bar> bars;
};

/// The landmark of `ninedot pattern` in its default size: P1..P8 as discs 0..7, P9 as disc 8.
Sheet nine_dot_sheet(double ring_radius_m = 0.080, double dot_radius_m = 0.0127, double centre_radius_m = 0.0254);

/// Look-alikes, for the tests that nothing else is taken for the landmark. Their middles are given in S0.
Sheet dot_ring_sheet(int dots, bool with_centre, double centre_radius_m = 0.0254);
Sheet dot_grid_sheet(int columns, int rows, double pitch_m, double dot_radius_m);
Sheet clock_sheet(double radius_m);
/// The landmark with squares of the dots' area for dots.
Sheet square_dot_sheet();
/// Spots of random place, size and darkness on the bare wall.
Sheet polka_dots(int count, double extent_m, double min_radius_m, double max_radius_m, std::uint64_t seed);

/// A band of less light across the wall: `|distance along the direction - offset| < width / 2`.
struct Shadow {
  double direction_rad = 0;  ///< of the band's normal in the wall: 0 = X0, pi/2 = Z0
  double offset_m = 0;       ///< of the band's middle from P9, along its normal
  double width_m = 0.1;
  double penumbra_m = 0.002;  ///< width of its soft edges
  double remaining = 0.3;     ///< light left inside, 0..1
};

/// Irradiance on the wall: level (1 + gradient . (X0, Z0)), never below a fiftieth of the level, times the shadows.
struct Light {
  double level = 0.85;
  double gradient_x_per_m = 0, gradient_z_per_m = 0;
  std::vector<Shadow> shadows;
};

/// Smooth random pattern, in the wall and on the board.
struct Texture {
  double reflectance = 0.35;
  double contrast = 0.15;  ///< amplitude, relative to the reflectance
  double grain_m = 0.12;   ///< size of its largest blotches
  std::uint64_t seed = 1;  ///< another seed, another pattern
};

/// A board in front of the sheet, its edge across it.
struct Board {
  double hidden_fraction = 0;  ///< of the sheet's area, 0 = no board
  double direction_rad = 0;    ///< side from which it comes: 0 = X0, pi/2 = Z0
  double width_m = 0.35, length_m = 0.6;
  Texture texture{0.25, 0.5, 0.03, 2};
};

/// Fog or a dirty window: light = (1 - veil) light + veil * level.
struct Haze {
  double veil = 0;
  double level = 0.5;
};

enum class ToneCurve : std::uint8_t { kLinear, kSrgb };

struct Sensor {
  double point_spread_px = 0.5;  ///< sigma of the Gaussian, before the pixels integrate
  double noise_a = 0;            ///< variance of the noise in linear light: a L + b
  double noise_b = 0;
  ToneCurve tone = ToneCurve::kSrgb;
};

/// Sets `noise_a` and `noise_b` so that the noise has this sigma at grey level 128, 85 % of it (in variance) shot
/// noise.
void set_noise(Sensor& sensor, double sigma_at_grey128_lsb);

/// height sin(2 pi d / length + phase), d the distance along the direction.
struct Wave {
  double height_m = 0;
  double direction_rad = 0;  ///< in the wall: 0 = X0, pi/2 = Z0
  double length_m = 0.1;
  double phase_rad = 0;
};

/// How far the wall, and all that hangs on it, stands out from the plane Y0 = 0: a sheet that is not flat. What is
/// painted keeps its (X0, Z0), so slopes must be small.
struct Relief {
  std::vector<Wave> waves;  ///< none: flat, whatever the plane below
  double offset_m = 0;      ///< added, as are these
  double slope_x = 0, slope_z = 0;
  double height_m(double x_m, double z_m) const;
};

struct Scene {
  Lens lens;
  CameraPose camera;
  std::vector<Sheet> sheets{nine_dot_sheet()};  ///< later ones cover earlier ones; the landmark is the first
  Light light;
  Texture wall;
  Board board;
  Haze haze;
  Sensor sensor;
  Relief relief;
};

/// Linear light per pixel, point spread included, noise not yet.
struct Exposure {
  int width_px = 0, height_px = 0;
  std::vector<double> light;
  double at(int x, int y) const { return light[static_cast<std::size_t>(y * width_px + x)]; }
};

/// Owns its pixels.
struct Picture {
  int width_px = 0, height_px = 0;
  std::vector<std::uint8_t> pixels;
  /// Valid while the picture lives and is not assigned to.
  ImageView view() const { return {pixels.data(), width_px, height_px, width_px}; }
};

/// Pixel (u, v) = integral of the scene's light under the point spread and the pixel's square.
/// Cells that an edge crosses are cast as 8 x 8 sub-samples, each with its own exact cover; the others as one.
/// \param scene  camera in front of the wall: position_m[1] > 0 (contract)
Exposure expose(const Scene& scene);

/// The same seed gives the same picture.
Picture read_out(const Exposure& exposure, const Sensor& sensor, std::uint64_t seed);

inline Picture render(const Scene& scene, std::uint64_t seed) { return read_out(expose(scene), scene.sensor, seed); }

/// Grey level 0..255 (not rounded) of linear light, and back.
double grey_from_light(double light, ToneCurve tone);
double light_from_grey(double grey_lsb, ToneCurve tone);

/// Where the board's edge lies: the board covers `X0 cos(direction) + Z0 sin(direction) > offset`.
double board_offset_m(const Board& board, const Sheet& sheet);

}  // namespace ninedot::test
