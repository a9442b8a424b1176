#pragma once
/// Pictures of printed landmarks on a plain wall, fast: rays are cast only where sheets are, and edges alone are looked
/// at closely. Everything here follows from the geometry and light; nothing of the estimator's is used.
///
/// What it leaves out: walls hide nothing, light is even, sheets are flat and do not shine.
#include <Eigen/Geometry>
#include <array>
#include <chrono>
#include <cstdint>
#include <vector>

#include "drivers/simulation/ray_field.h"
#include "drivers/simulation/sensor_noise.h"
#include "image/chroma_view.h"
#include "image/image_buffer.h"

namespace ninedot {

/// Share of the light that is thrown back, linear [1].
struct Reflectance {
  float red = 0, green = 0, blue = 0;  ///< [1]
};

/// A landmark that hangs in the world: P1 lowest, the others clockwise as the viewer sees them, P9 in the middle. Its
/// own frame: X to the viewer's left, Y out of the sheet, Z up.
struct HungSheet {
  double ring_radius_m = 0.080, dot_radius_m = 0.0127, centre_radius_m = 0.0254;
  double half_side_m = 0.105;  ///< of the square paper
  Eigen::Isometry3d T_world_sheet = Eigen::Isometry3d::Identity();
  std::array<Reflectance, 9> inks{};  ///< of P1..P9
};

/// Three moments of a camera that moves: the middle of the exposure of the middle row, and as long before and after it
/// as `half`. Between them its motion is taken as even in its acceleration.
struct ExposureMotion {
  std::array<Eigen::Isometry3d, 3> T_world_camera{Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(),
                                                  Eigen::Isometry3d::Identity()};
  std::chrono::duration<double> half_s{};  ///< 0: all three are one
};

struct RendererOptions {
  double blur_px = 0.6;    ///< 1-sigma of the lens's point spread, up to 2
  double noise_lsb = 2;    ///< 1-sigma at grey level 128
  std::uint64_t seed = 1;  ///< of the noise
  double row_time_s = 0;   ///< from one row's exposure to the next one's; 0: all at once
  double exposure_s = 0;   ///< 0: nothing is blurred by motion
};

/// Memory: everything is allocated by the constructor. Threads: one.
class SheetRenderer {
 public:
  /// Pictures have colour where a sheet has.
  SheetRenderer(const CameraModel& camera, std::vector<HungSheet> sheets, const RendererOptions& options);

  /// \param hidden  everything is covered
  /// \param frame_number  the noise is another one for each
  void render(const ExposureMotion& motion, bool hidden, std::uint64_t frame_number) noexcept;

  /// No ray of the picture is farther from the optical axis [1, at z = 1].
  double farthest_ray() const noexcept { return rays_.farthest(); }

  /// The newest picture. Lifetime: until the next one.
  ImageView luma() const noexcept { return luma_.view(); }
  /// Empty where no sheet has colour.
  ChromaView chroma() const noexcept;

 private:
  using Homography = Eigen::Matrix3d;
  /// Columns and rows from..to - 1.
  struct Area {
    int u0 = 0, v0 = 0, u1 = 0, v1 = 0;
    bool empty() const noexcept { return u0 >= u1 || v0 >= v1; }
  };
  /// A sheet in the picture.
  struct Sight {
    const HungSheet* sheet = nullptr;
    double distance_m = 0;
    std::array<Homography, 3> plane_from_ray;  // up to a factor: by powers of the time from the middle, in `half`
    Area area;                                 // of its paper
    double blur_px = 0;                        // how far it moves while a row is exposed
  };
  using Light = std::array<float, 3>;  // red, green, blue; grey pictures have the first one alone

  bool find(const HungSheet& sheet, const ExposureMotion& motion, Sight& sight) const noexcept;
  template <std::size_t kChannels>
  void paint(const Sight& sight, double half_s) noexcept;
  template <std::size_t kChannels>
  void develop(const Area& area) noexcept;
  void read_out(std::uint64_t frame_number) noexcept;
  Area grown(const Area& area, int by_px, int border_px) const noexcept;
  Area in_whole_blocks(const Area& area) const noexcept;  // of chroma
  std::size_t light_at(int u, int v) const noexcept;
  void fill_clean(std::uint16_t level, const Area& area) noexcept;

  const RayField rays_;
  const CameraModel camera_;
  const std::vector<HungSheet> sheets_;
  const RendererOptions options_;
  const bool has_colour_;
  const ToneCurve tone_;
  const SensorNoise noise_;
  std::vector<float> kernel_;    // of the point spread, from its middle on
  std::vector<Sight> sights_;    // of this picture, the farthest first
  std::vector<Area> developed_;  // of the picture before
  bool was_hidden_ = true;
  // Light of the picture and its border, before and after the first half of the blur; one plane for each channel.
  std::array<std::vector<float>, 3> light_, half_blurred_;
  // Grey levels without noise [1/256 LSB]: luma, Cb, Cr.
  std::array<std::vector<std::uint16_t>, 3> clean_;
  int chroma_width_, chroma_height_;
  ImageBuffer luma_;
  std::array<std::vector<std::uint8_t>, 2> chroma_;
};

}  // namespace ninedot
