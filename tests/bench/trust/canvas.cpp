// Each pixel of the picture is four or nine rays; where they meet the canvas its levels are interpolated and averaged,
// then blurred, lit and made noisy.
#include "tests/bench/trust/canvas.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/bench/trust/strip.h"
#include "tests/support/renderer_optics.h"

namespace ninedot::bench {
namespace {

constexpr double kFar = 3;  // of the canvas's unit: beyond, nine rays per pixel instead of four

// Four uniform numbers out of one: normal enough for grey levels, and ten times as fast.
double noise_at(std::uint64_t seed, std::uint64_t counter) {
  std::uint64_t bits = test::random_bits(seed, counter);
  double sum = 0;
  for (int i = 0; i < 4; ++i, bits >>= 16U) sum += static_cast<double>(bits & 0xFFFFU);
  return (sum / 65535 - 2) * std::sqrt(3.0);
}

double smooth_step(double t) { return t * t * (3 - 2 * t); }

// Random levels -1..1 on whole numbers, interpolated.
class ValueNoise {
 public:
  explicit ValueNoise(std::uint64_t seed) : seed_(seed) {}
  // x, y >= 0; cheap along x.
  double at(double x, double y) {
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    if (i != i_ || j != j_) {
      i_ = i, j_ = j;
      for (int k = 0; k < 4; ++k) corners_[static_cast<std::size_t>(k)] = level(i + k % 2, j + k / 2);
    }
    const double u = smooth_step(x - i), v = smooth_step(y - j);
    return (corners_[0] * (1 - u) + corners_[1] * u) * (1 - v) + (corners_[2] * (1 - u) + corners_[3] * u) * v;
  }

 private:
  double level(int i, int j) const {
    return 2 * test::random_uniform(seed_, static_cast<std::uint64_t>(i) * 65537 + static_cast<std::uint64_t>(j)) - 1;
  }
  std::uint64_t seed_;
  int i_ = -1, j_ = -1;
  std::array<double, 4> corners_{};
};

// Along rows, then whole rows over each other; edges are repeated.
std::vector<float> blurred(const std::vector<float>& levels, int width, int height, double sigma_px) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_px));
  std::vector<float> weights;
  double sum = 0;
  for (int d = -reach; d <= reach; ++d) sum += std::exp(-d * d / (2 * sigma_px * sigma_px));
  for (int d = -reach; d <= reach; ++d)
    weights.push_back(static_cast<float>(std::exp(-d * d / (2 * sigma_px * sigma_px)) / sum));
  std::vector<float> rows(levels.size()), all(levels.size());
  for (int y = 0; y < height; ++y)
    for (int d = -reach; d <= reach; ++d)
      for (int x = 0; x < width; ++x)
        rows[static_cast<std::size_t>(y * width + x)] +=
            weights[static_cast<std::size_t>(d + reach)] *
            levels[static_cast<std::size_t>(y * width + std::clamp(x + d, 0, width - 1))];
  for (int y = 0; y < height; ++y)
    for (int d = -reach; d <= reach; ++d) {
      const int from = std::clamp(y + d, 0, height - 1);
      for (int x = 0; x < width; ++x)
        all[static_cast<std::size_t>(y * width + x)] +=
            weights[static_cast<std::size_t>(d + reach)] * rows[static_cast<std::size_t>(from * width + x)];
    }
  return all;
}

}  // namespace

Canvas::Canvas(double level)
    : levels_(static_cast<std::size_t>(kSide_px) * static_cast<std::size_t>(kSide_px), static_cast<float>(level)) {}

// distance(dx, dy): signed, of a place relative to the middle, negative inside.
template <typename Signed>
void Canvas::paint(double x, double y, double reach, double level, const Signed& distance) {
  const auto pixel = [](double at) { return static_cast<int>(std::floor((at + 1) * kPixelsPerUnit)); };
  const int left = std::max(0, pixel(x - reach) - 1), right = std::min(kSide_px - 1, pixel(x + reach) + 1);
  const int top = std::max(0, pixel(y - reach) - 1), bottom = std::min(kSide_px - 1, pixel(y + reach) + 1);
  for (int j = top; j <= bottom; ++j)
    for (int i = left; i <= right; ++i) {
      const double dx = (i + 0.5) / kPixelsPerUnit - 1 - x, dy = (j + 0.5) / kPixelsPerUnit - 1 - y;
      const double cover = std::clamp(0.5 - distance(dx, dy) * kPixelsPerUnit, 0.0, 1.0);
      float& at = levels_[static_cast<std::size_t>(j * kSide_px + i)];
      at += static_cast<float>(cover * (level - static_cast<double>(at)));
    }
}

void Canvas::ellipse(double x, double y, double along, double across, double angle_rad, double level) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  paint(x, y, std::max(along, across), level, [=](double dx, double dy) {
    const double u = (c * dx + s * dy) / along, v = (c * dy - s * dx) / across;
    return (std::sqrt(u * u + v * v) - 1) * std::min(along, across);
  });
}

void Canvas::box(double x, double y, double half_width, double half_height, double angle_rad, double corner,
                 double level) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  paint(x, y, std::hypot(half_width, half_height), level, [=](double dx, double dy) {
    const double u = std::abs(c * dx + s * dy) - half_width + corner;
    const double v = std::abs(c * dy - s * dx) - half_height + corner;
    return std::hypot(std::max(u, 0.0), std::max(v, 0.0)) + std::min(std::max(u, v), 0.0) - corner;
  });
}

void Canvas::bar(double x0, double y0, double x1, double y1, double width, double level) {
  const double length = std::hypot(x1 - x0, y1 - y0);
  box((x0 + x1) / 2, (y0 + y1) / 2, length / 2 + width / 2, width / 2, std::atan2(y1 - y0, x1 - x0), width / 2, level);
}

void Canvas::ball(double x, double y, double radius, double light_from_rad, double level_low, double level_high) {
  constexpr int kSteps = 12;  // discs that shrink towards the light
  for (int i = 0; i < kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    disc(x + 0.5 * t * radius * std::cos(light_from_rad), y + 0.5 * t * radius * std::sin(light_from_rad),
         radius * (1 - t) * (1 + 0.4 * t), level_low + t * (level_high - level_low));
  }
}

void Canvas::noise(std::uint64_t seed, double amplitude_lsb, double roughness, double grain) {
  double frequency = 1 / grain, amplitude = amplitude_lsb;
  for (std::uint64_t octave = 0; octave < 6 && frequency < kPixelsPerUnit; ++octave) {
    ValueNoise pattern(seed + octave);
    const double step = frequency / kPixelsPerUnit;
    for (int j = 0; j < kSide_px; ++j)
      for (int i = 0; i < kSide_px; ++i)
        levels_[static_cast<std::size_t>(j * kSide_px + i)] +=
            static_cast<float>(amplitude * pattern.at(i * step, j * step));
    frequency *= 2, amplitude *= roughness;
  }
}

void Canvas::threshold(double level, double dark, double light) {
  for (float& at : levels_) at = static_cast<float>(static_cast<double>(at) < level ? dark : light);
}

double Canvas::at(double x, double y, bool repeat) const {
  constexpr int kRepeats = 64;  // so many canvases to each side: whole numbers by cutting off need positive ones
  const double u = (x + 1) * kPixelsPerUnit - 0.5, v = (y + 1) * kPixelsPerUnit - 0.5;
  const bool inside = u >= 0 && v >= 0 && u < kSide_px - 1 && v < kSide_px - 1;
  if (!inside && (!repeat || std::max(std::abs(u), std::abs(v)) > (kRepeats - 1) * kSide_px))
    return static_cast<double>(levels_.front());
  const int iu = static_cast<int>(u + kRepeats * kSide_px), iv = static_cast<int>(v + kRepeats * kSide_px);
  const double a = u + kRepeats * kSide_px - iu, b = v + kRepeats * kSide_px - iv;
  const auto pixel = [&](int i, int j) {
    return static_cast<double>(
        levels_[static_cast<std::size_t>((j & (kSide_px - 1)) * kSide_px + (i & (kSide_px - 1)))]);
  };
  return (pixel(iu, iv) * (1 - a) + pixel(iu + 1, iv) * a) * (1 - b) +
         (pixel(iu, iv + 1) * (1 - a) + pixel(iu + 1, iv + 1) * a) * b;
}

Look random_look(test::Random& random) {
  constexpr double kDegree = std::numbers::pi / 180;
  Look look;
  test::Viewpoint view;
  view.distance_m = std::exp(random.uniform(std::log(0.9), std::log(9.0)));
  view.tilt_rad = random.uniform(0, 60 * kDegree);
  view.azimuth_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  view.roll_rad = random.uniform(-25 * kDegree, 25 * kDegree);
  view.off_axis_x_rad = random.uniform(-6 * kDegree, 6 * kDegree);
  view.off_axis_y_rad = random.uniform(-5 * kDegree, 5 * kDegree);
  look.camera = test::look_at_landmark(view);
  look.repeat = random.uniform(0, 1) < 0.5;
  look.blur_px = random.uniform(0.3, 1.4);
  look.noise_lsb = random.uniform(0.5, 3.5);
  look.light_slope = random.uniform(-0.5, 0.5);
  look.fold_phase_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
  return look;
}

test::Picture look_at(const Canvas& canvas, const Look& look, std::uint64_t seed) {
  const test::Lens lens = trust_lens();
  const Eigen::Matrix3d R = test::rotation_of(look.camera);
  const Eigen::Vector3d centre(look.camera.position_m.data());
  const auto level_at = [&](const Eigen::Vector3d& ray) {
    if (ray.y() >= -1e-3) return canvas.at(1e9, 1e9, false);
    const double reach = -centre.y() / ray.y();
    double x = centre.x() + reach * ray.x(), z = centre.z() + reach * ray.z();
    if (look.fold == 0) return canvas.at(x, z, look.repeat);
    const double phase = 5 * x + 2 * z + look.fold_phase_rad;
    const double shade = 1 + 4 * look.fold * std::cos(phase);
    z += look.fold * std::sin(phase), x += look.fold * std::sin(0.7 * phase + 3 * z);
    return shade * canvas.at(x, z, look.repeat);
  };
  // From afar a pixel sees more of the canvas's.
  const int samples = centre.norm() > kFar ? 3 : 2;
  const auto offset_px = [&](int i) { return (i + 0.5) / samples - 0.5; };
  std::vector<float> levels;
  levels.reserve(static_cast<std::size_t>(lens.width_px) * static_cast<std::size_t>(lens.height_px));
  const Eigen::Vector3d per_u = R.col(0) / lens.fx_px, per_v = R.col(1) / lens.fy_px;
  const Eigen::Vector3d corner = R.col(2) - lens.cx_px * per_u - lens.cy_px * per_v;
  for (int v = 0; v < lens.height_px; ++v)
    for (int u = 0; u < lens.width_px; ++u) {
      double sum = 0;
      for (int j = 0; j < samples; ++j)
        for (int i = 0; i < samples; ++i)
          sum += level_at(corner + (u + offset_px(i)) * per_u + (v + offset_px(j)) * per_v);
      const double light = 1 + look.light_slope * (u / lens.cx_px - 1) / 2;
      levels.push_back(static_cast<float>(sum / (samples * samples) * light));
    }
  levels = blurred(levels, lens.width_px, lens.height_px, look.blur_px);
  test::Picture picture{lens.width_px, lens.height_px, {}};
  picture.pixels.reserve(levels.size());
  for (std::size_t i = 0; i < levels.size(); ++i)
    picture.pixels.push_back(static_cast<std::uint8_t>(
        std::clamp(static_cast<double>(levels[i]) + look.noise_lsb * noise_at(seed, i) + 0.5, 0.0, 255.0)));
  return picture;
}

}  // namespace ninedot::bench
