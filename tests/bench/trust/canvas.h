#pragma once
/// A painter's canvas and a camera before it: pictures of things that are no landmark. It shares nothing with the
/// renderer but the place of the camera, and paints what would be hard to describe by geometry alone.
#include <cstdint>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/renderer.h"

namespace ninedot::bench {

/// Coordinates -1..1 along both axes; grey levels 0..255. Outlines are smoothed over a pixel of the canvas. What is
/// painted later covers what was there.
class Canvas {
 public:
  static constexpr int kSide_px = 1024;
  static constexpr double kPixelsPerUnit = kSide_px / 2.0;

  explicit Canvas(double level);

  void disc(double x, double y, double radius, double level) { ellipse(x, y, radius, radius, 0, level); }
  /// \param along  half its axis in the direction `angle_rad`
  void ellipse(double x, double y, double along, double across, double angle_rad, double level);
  /// A rectangle with rounded corners. \param half_width  in the direction `angle_rad`
  void box(double x, double y, double half_width, double half_height, double angle_rad, double corner, double level);
  /// A stroke with round ends.
  void bar(double x0, double y0, double x1, double y1, double width, double level);
  /// A disc whose level goes from `level_low` on one side to `level_high` on the other.
  void ball(double x, double y, double radius, double light_from_rad, double level_low, double level_high);
  /// Adds a random pattern of octaves. \param roughness  each octave's amplitude over that of the next coarser one
  /// \param grain  size of the coarsest blotches
  void noise(std::uint64_t seed, double amplitude_lsb, double roughness, double grain);
  /// Dark below this level, light above it.
  void threshold(double level, double dark, double light);

  /// Level between the pixels. \param repeat  beyond the canvas it begins anew; else there is its corner's level
  double at(double x, double y, bool repeat) const;

 private:
  template <typename Signed>
  void paint(double x, double y, double reach, double level, const Signed& distance);
  std::vector<float> levels_;
};

/// How a canvas is looked at.
struct Look {
  test::CameraPose camera;  ///< before the canvas, whose unit is a metre
  bool repeat = false;
  double blur_px = 0.6;
  double noise_lsb = 1.5;
  double light_slope = 0;  ///< relative change of the light from the left to the right edge of the picture
  double fold = 0;         ///< how far a folded cloth displaces what is on it, in units of the canvas
  double fold_phase_rad = 0;
};

/// Tilt up to 60 degrees, roll up to 25, at any distance from which the canvas fills a fifth of the picture or more.
Look random_look(test::Random& random);

test::Picture look_at(const Canvas& canvas, const Look& look, std::uint64_t seed);

}  // namespace ninedot::bench
