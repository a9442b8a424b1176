/// Whatever a picture shows, the detector ends, stays inside its memory and hands over plain numbers. The bytes say
/// what is drawn rather than being pixels: size, light, noise, then shapes one after another, a landmark among them,
/// then sharpening or blur; so that a changed byte is another scene and not another speck of noise.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/contract.h"
#include "detect/detector.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

/// Reads bytes; beyond their end everything is zero.
class Script {
 public:
  explicit Script(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool ended() const { return next_ >= bytes_.size(); }
  int byte() { return ended() ? 0 : bytes_[next_++]; }
  /// In [low, high].
  double between(double low, double high) { return low + (high - low) * byte() / 255; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
};

constexpr int kMaxShapes = 24;
constexpr int kMaxDots = 40;  // equal dots side by side are what takes the detector longest: about their number squared

struct Canvas {
  Canvas(int width, int height, double paper)
      : width_px(width), height_px(height), light(static_cast<std::size_t>(width * height), paper) {}
  double& at(int x, int y) { return light[static_cast<std::size_t>(y * width_px + x)]; }

  /// light = ink where `cover(x, y)` is 1, within the box.
  template <typename Cover>
  void paint(double x_px, double y_px, double reach_px, double ink, Cover&& cover) {
    const int x0 = std::max(static_cast<int>(x_px - reach_px), 0), y0 = std::max(static_cast<int>(y_px - reach_px), 0);
    const int x1 = std::min(static_cast<int>(x_px + reach_px) + 2, width_px);
    const int y1 = std::min(static_cast<int>(y_px + reach_px) + 2, height_px);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        const double share = std::clamp(cover(x, y), 0.0, 1.0);
        at(x, y) += share * (ink - at(x, y));
      }
  }
  void disc(double x_px, double y_px, double a_px, double b_px, double angle_rad, double ink) {
    if (++dots > kMaxDots) return;
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    paint(x_px, y_px, std::max(a_px, b_px) + 1, ink, [&](int x, int y) {
      const double u = (c * (x - x_px) + s * (y - y_px)) / a_px, v = (c * (y - y_px) - s * (x - x_px)) / b_px;
      return 0.5 + (1 - std::hypot(u, v)) * std::min(a_px, b_px);
    });
  }
  void ring(double x_px, double y_px, double radius_px, double width, double ink) {
    paint(x_px, y_px, radius_px + width, ink,
          [&](int x, int y) { return 0.5 + width / 2 - std::abs(std::hypot(x - x_px, y - y_px) - radius_px); });
  }
  void line(double x0_px, double y0_px, double angle_rad, double length_px, double width, double ink) {
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    paint(x0_px, y0_px, length_px, ink, [&](int x, int y) {
      const double along = c * (x - x0_px) + s * (y - y0_px), across = c * (y - y0_px) - s * (x - x0_px);
      return std::min(0.5 + width / 2 - std::abs(across), length_px - std::abs(along));
    });
  }
  /// A patch of noise, cells of `cell` pixels.
  void texture(double x_px, double y_px, double reach_px, int cell, double contrast, std::uint64_t seed) {
    const int x0 = std::max(static_cast<int>(x_px - reach_px), 0), y0 = std::max(static_cast<int>(y_px - reach_px), 0);
    const int x1 = std::min(static_cast<int>(x_px + reach_px), width_px);
    const int y1 = std::min(static_cast<int>(y_px + reach_px), height_px);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x)
        at(x, y) += contrast * (test::random_uniform(seed, static_cast<std::uint64_t>(y / cell * 4096 + x / cell)) - 1);
  }
  /// Mixes every pixel with the mean of its neighbours: > 0 sharpens, < 0 blurs.
  void sharpen(double amount) {
    const std::vector<double> before = light;
    const auto was = [&](int x, int y) {
      return before[static_cast<std::size_t>(std::clamp(y, 0, height_px - 1) * width_px +
                                             std::clamp(x, 0, width_px - 1))];
    };
    for (int y = 0; y < height_px; ++y)
      for (int x = 0; x < width_px; ++x)
        at(x, y) += amount * (was(x, y) - (was(x - 1, y) + was(x + 1, y) + was(x, y - 1) + was(x, y + 1)) / 4);
  }

  int width_px, height_px;
  std::vector<double> light;
  int dots = 0;
};

/// Sheet to ray: the landmark turned by three angles before the camera.
Eigen::Matrix3d pose_homography(Script& script) {
  const double distance_m = 0.12 + 0.01 * script.byte();
  const double x_m = script.between(-0.5, 0.5) * distance_m, y_m = script.between(-0.5, 0.5) * distance_m;
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(script.between(-3.2, 3.2), Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(script.between(-1.5, 1.5), Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(script.between(-1.5, 1.5), Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  Eigen::Matrix3d H;
  // Upright before the camera: X0 to the left, Z0 up.
  H << -R.col(0), -R.col(1), Eigen::Vector3d(x_m, y_m, distance_m);
  return H;
}

void draw_landmark(Script& script, const CameraModel& camera, Canvas& canvas) {
  const LandmarkGeometry sheet;
  const Eigen::Matrix3d H = pose_homography(script);
  const double ink = script.between(0, 120);
  const int hidden = script.byte();  // a bit for each dot of the ring
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (dot != kCentreDot && ((hidden >> dot) & 1) != 0 && hidden != 255) continue;
    const Eigen::Vector3d middle = H * sheet.centre_m(dot).homogeneous();
    if (!(middle.z() > 0.02)) continue;
    const Eigen::Vector2d px = camera.pixel_from_normalised(middle.hnormalized());
    const Eigen::Matrix3d inverse = H.inverse();
    const double reach_px = 2 * sheet.radius_m(dot) * camera.fx_px / middle.z() + 2;
    canvas.paint(px.x(), px.y(), std::min(reach_px, 200.0), ink, [&](int x, int y) {
      const Eigen::Vector3d ray((x - camera.cx_px) / camera.fx_px, (y - camera.cy_px) / camera.fy_px, 1);
      const Eigen::Vector2d off_m = (inverse * ray).hnormalized() - sheet.centre_m(dot);
      return 0.5 + (sheet.radius_m(dot) - off_m.norm()) * camera.fx_px / middle.z();
    });
  }
}

void draw_shapes(Script& script, const CameraModel& camera, Canvas& canvas) {
  for (int shape = 0; shape < kMaxShapes && !script.ended(); ++shape) {
    const int what = script.byte();
    if (what % 8 == 5) {
      draw_landmark(script, camera, canvas);
      continue;
    }
    const double x_px = script.between(0, canvas.width_px), y_px = script.between(0, canvas.height_px);
    const double size_px = 0.5 + 0.2 * script.byte(), angle_rad = script.between(-3.2, 3.2);
    const double ink = script.between(0, 255), detail = script.between(0, 1);
    switch (what % 8) {
      case 0:
      case 1:
        canvas.disc(x_px, y_px, size_px, size_px * (0.1 + 0.9 * detail), angle_rad, ink);
        break;
      case 2:
        canvas.ring(x_px, y_px, size_px, 0.5 + 4 * detail, ink);
        break;
      case 3:
        canvas.line(x_px, y_px, angle_rad, 3 * size_px, 0.5 + 6 * detail, ink);
        break;
      case 4: {  // a ring of dots
        const int dots = 3 + what / 8 % 10;
        for (int i = 0; i < dots; ++i) {
          const double a_rad = angle_rad + i * 6.2831853 / dots;
          canvas.disc(x_px + size_px * std::cos(a_rad), y_px + size_px * std::sin(a_rad), 0.05 + detail * size_px / 3,
                      0.05 + detail * size_px / 3, 0, ink);
        }
        break;
      }
      case 6: {  // a grid of dots
        const double pitch_px = 2 + 12 * detail;
        for (int row = 0; row < 4; ++row)
          for (int column = 0; column < 4; ++column)
            canvas.disc(x_px + column * pitch_px, y_px + row * pitch_px, 0.3 * pitch_px, 0.3 * pitch_px, 0, ink);
        break;
      }
      default:
        canvas.texture(x_px, y_px, 2 * size_px, 1 + what / 8 % 4, ink, static_cast<std::uint64_t>(what));
        break;
    }
  }
}

std::vector<std::uint8_t> read_out(Canvas& canvas, double noise_lsb, std::uint64_t seed) {
  std::vector<std::uint8_t> pixels(canvas.light.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double light = canvas.light[i] + (noise_lsb > 0 ? noise_lsb * test::random_normal(seed, i) : 0);
    pixels[i] = static_cast<std::uint8_t>(std::clamp(light, 0.0, 255.0));
  }
  return pixels;
}

void check(const LandmarkObservation& seen, const CameraModel& camera) {
  EXPECTS(seen.H_ray_plane.allFinite());
  EXPECTS(*std::min_element(seen.numbering_chi2.begin(), seen.numbering_chi2.end()) == 0);
  EXPECTS(std::isfinite(*std::max_element(seen.numbering_chi2.begin(), seen.numbering_chi2.end())));
  int count = 0;
  for (const DotObservation& dot : seen.dots) {
    count += dot.seen;
    EXPECTS(dot.visible_fraction >= 0 && dot.visible_fraction <= 1);
    if (!dot.seen) continue;
    EXPECTS(dot.centroid_px.x() >= 0 && dot.centroid_px.x() < camera.width_px);
    EXPECTS(dot.centroid_px.y() >= 0 && dot.centroid_px.y() < camera.height_px);
    EXPECTS(dot.semi_major_px >= dot.semi_minor_px && dot.semi_minor_px > 0 && dot.semi_major_px < 1000);
    EXPECTS(std::isfinite(dot.angle_rad));
  }
  EXPECTS(count == seen.seen_count);
}

}  // namespace
}  // namespace ninedot

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace ninedot;
  if (count < 8) return 0;
  Script script({bytes, count});
  CameraModel camera;
  camera.width_px = 16 + script.byte() % 145;
  camera.height_px = 16 + script.byte() % 145;
  camera.fx_px = camera.fy_px = 160;
  camera.cx_px = 0.5 * (camera.width_px - 1), camera.cy_px = 0.5 * (camera.height_px - 1);
  const double paper = 40 + 0.8 * script.byte();
  const int noise = script.byte();
  const auto seed = static_cast<std::uint64_t>(script.byte());
  const double sharpening = script.between(-1, 3);
  const int where = script.byte();
  Script expected = script;  // the place to look is drawn from the bytes of the first shapes

  Canvas canvas(camera.width_px, camera.height_px, paper);
  draw_shapes(script, camera, canvas);
  canvas.sharpen(sharpening);
  const std::vector<std::uint8_t> pixels = read_out(canvas, noise < 64 ? 0 : 0.1 * (noise - 64), seed);
  const ImageView luma{pixels.data(), camera.width_px, camera.height_px, camera.width_px};

  Detector detector(camera, LandmarkGeometry{});
  const auto found = detector.find_landmarks(luma);
  if (found) EXPECTS(!found->empty() && found->size() <= kMaxLandmarksInView);
  std::optional<LandmarkObservation> seen;
  if (found) seen = found->front();
  if (seen) check(*seen, camera);
  LandmarkForecast forecast(seen ? *seen : LandmarkObservation{}, static_cast<ForecastNumbers>(where / 2 % 3));
  if (!seen || where % 2 == 1) {
    (void)expected.byte();
    forecast.H_ray_plane = pose_homography(expected);
    if (where % 16 == 1) forecast.H_ray_plane(where / 16 % 3, where / 64 % 3) = std::nan("");
    if (where % 16 == 3) forecast.H_ray_plane.row(2).setZero();
    if (where % 16 == 5) forecast.H_ray_plane *= 1e300;
  }
  if (const auto near = detector.find_landmark_near(luma, forecast)) check(*near, camera);
  return 0;
}
