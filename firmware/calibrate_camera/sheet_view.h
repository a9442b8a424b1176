#pragma once
/// What one picture shows of a sheet of dots whose places are known: a landmark, or a printed grid.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/disc.h"
#include "geometry/landmark.h"
#include "image/image_view.h"
#include "image/noise.h"

namespace ninedot {

/// Which disc of a sheet, and where its dark area has its centroid.
struct SeenDisc {
  std::size_t disc = 0;  ///< index of it
  Eigen::Vector2d centre_px{0, 0};
};

/// A place on a disc's outline, measured in the picture across the outline.
struct EdgePoint {
  std::size_t disc = 0;  ///< index of it
  Eigen::Vector2d at_px{0, 0};
  double sigma_px = 0;  ///< 1-sigma across the outline, from the picture's noise
};

/// What took a picture.
enum class SensorKind : std::uint8_t {
  kGrey,
  kColour,  ///< behind a mosaic of red, green and blue, which somebody interpolated: see edge_points.cpp
};

/// A part of a picture, with its own pixels.
struct PictureCrop {
  std::vector<std::uint8_t> pixels;
  int left_px = 0, top_px = 0;  ///< of its first pixel in the whole picture
  int width_px = 0, height_px = 0;
  SensorKind sensor = SensorKind::kGrey;
  /// Valid while the crop lives and is not assigned to.
  ImageView view() const noexcept { return {pixels.data(), width_px, height_px, width_px}; }
};

struct SheetView {
  std::size_t recording = 0;  ///< index of it
  std::uint64_t frame = 0;    ///< its number there
  std::vector<SeenDisc> seen;
  PictureCrop picture;  ///< all of the discs and some pixels around them
  PictureNoise noise;   ///< of the whole picture
  std::vector<EdgePoint> edges;
};

/// The discs of a landmark: P1..P8, then P9.
std::vector<PlaneDisc> discs_of(const LandmarkGeometry& landmark);

/// Keeps of a picture what its sheet covers. \param seen  at least four, else the view has no picture
/// Memory: allocates. Threads: pure.
SheetView keep_view(const ImageView& luma, SensorKind sensor, std::vector<SeenDisc> seen,
                    std::span<const PlaneDisc> discs);

/// Mean distance between where two views show the discs that both do; infinite where fewer than four are in both. [px]
double distance_px(const SheetView& a, const SheetView& b);

}  // namespace ninedot
