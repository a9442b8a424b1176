#include "tests/bench/trust/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/bench/crlb.h"

namespace ninedot::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kHalfTurn_rad = std::numbers::pi;

void even_light(MovingView& view, test::Random& random) {
  view.at.distance_m = std::exp(random.uniform(std::log(0.5), std::log(6.0)));
}

void nearly_frontal(MovingView& view, test::Random& random) {
  view.at.distance_m = random.uniform(3, 4.5);
  view.at.tilt_rad = random.uniform(0, 5 * kDegree);
  view.per_frame.tilt_rad = 0;
}

void steep(MovingView& view, test::Random& random) {
  view.at.tilt_rad = random.uniform(60 * kDegree, 75 * kDegree);
  view.per_frame.tilt_rad = 0;
}

void shadows(MovingView& view, test::Random& random, int bands, double pitch_m, double penumbra_m) {
  const double direction_rad = random.uniform(-kHalfTurn_rad, kHalfTurn_rad), remaining = random.uniform(0.2, 0.6);
  const double share = random.uniform(0.35, 0.65), offset_m = random.uniform(-0.06, 0.06);
  for (int i = 0; i < bands; ++i)
    view.scene.light.shadows.push_back(
        {direction_rad, offset_m + (i - (bands - 1) / 2.0) * pitch_m, share * pitch_m, penumbra_m, remaining});
  view.has_bound = false;
}

void hard_shadow(MovingView& view, test::Random& random) {
  const double pitch_m = random.uniform(0.06, 0.4);
  shadows(view, random, 1, pitch_m, random.uniform(0.001, 0.004));
}

void soft_shadow(MovingView& view, test::Random& random) {
  const double pitch_m = random.uniform(0.1, 0.4);
  shadows(view, random, 1, pitch_m, random.uniform(0.02, 0.08));
}

void striped_shadow(MovingView& view, test::Random& random) {
  const double pitch_m = std::exp(random.uniform(std::log(0.008), std::log(0.08)));
  shadows(view, random, static_cast<int>(0.4 / pitch_m), pitch_m, pitch_m * random.uniform(0.03, 0.4));
}

void slope_of_light(MovingView& view, test::Random& random) {
  const double from_rad = random.uniform(-kHalfTurn_rad, kHalfTurn_rad), slope_per_m = random.uniform(1.5, 6);
  view.scene.light.gradient_x_per_m = slope_per_m * std::cos(from_rad);
  view.scene.light.gradient_z_per_m = slope_per_m * std::sin(from_rad);
  view.scene.light.level = 0.55;
  view.has_bound = false;
}

// The plane that lies best through the nine dots is where the landmark is said to be.
void lay_flat(test::Relief& relief) {
  const std::vector<test::Disc> dots = test::nine_dot_sheet().discs;
  double sum = 0, sum_x = 0, sum_z = 0, squares = 0;
  for (const test::Disc& dot : dots) {
    const double height_m = relief.height_m(dot.x_m, dot.z_m);
    sum += height_m, sum_x += dot.x_m * height_m, sum_z += dot.z_m * height_m;
    squares += dot.x_m * dot.x_m;  // as many along Z0: the ring is round, and its middle is the origin
  }
  relief.offset_m -= sum / static_cast<double>(dots.size());
  relief.slope_x -= sum_x / squares, relief.slope_z -= sum_z / squares;
}

void warp(MovingView& view, test::Random& random, int waves, double least_m, double most_m, double height_per_length) {
  for (int i = 0; i < waves; ++i) {
    const double length_m = random.uniform(least_m, most_m);
    view.scene.relief.waves.push_back({length_m * height_per_length * random.uniform(0.3, 1),
                                       random.uniform(-kHalfTurn_rad, kHalfTurn_rad), length_m,
                                       random.uniform(-kHalfTurn_rad, kHalfTurn_rad)});
  }
  lay_flat(view.scene.relief);
  view.has_bound = false;
}

void smooth_warp(MovingView& view, test::Random& random) { warp(view, random, 2, 0.3, 0.6, 0.008); }
void bumpy_warp(MovingView& view, test::Random& random) { warp(view, random, 6, 0.04, 0.1, 0.008); }

template <int kPercent>
void hidden(MovingView& view, test::Random& random) {
  view.scene.board.hidden_fraction = kPercent / 100.0;
  view.scene.board.direction_rad = random.uniform(-kHalfTurn_rad, kHalfTurn_rad);
  view.scene.board.texture.seed = random.bits();
  view.scene.board.texture.reflectance = random.uniform(0.1, 0.6);
}

void motion_blur(MovingView& view, test::Random& random) {
  view.smear_px = random.uniform(2, 10);
  view.smear_rad = random.uniform(-kHalfTurn_rad, kHalfTurn_rad);
  view.has_bound = false;
}

void rolled(MovingView& view, test::Random& random) {
  view.at.roll_rad = random.uniform(15 * kDegree, 25 * kDegree) * (random.uniform(-1, 1) < 0 ? -1 : 1);
  view.per_frame.roll_rad = 0;
}

void low_light(MovingView& view, test::Random& random) {
  view.scene.light.level = random.uniform(0.12, 0.3);
  test::set_noise(view.scene.sensor, random.uniform(5, 10));
}

/// So dark that noise is a quarter to a sixth of what ink and paper differ by.
void poor_light(MovingView& view, test::Random& random) {
  const double level = random.uniform(0.12, 0.3);
  view.scene.light.level = level;
  const auto grey_lsb = [&](double reflectance) {
    return test::grey_from_light(level * reflectance, view.scene.sensor.tone);
  };
  const test::Sheet& sheet = view.scene.sheets.front();
  const double contrast_lsb = grey_lsb(sheet.reflectance) - grey_lsb(sheet.discs.front().reflectance);
  test::set_noise(view.scene.sensor, contrast_lsb / random.uniform(4, 6));
}

void veiled(MovingView& view, test::Random& random) {
  view.scene.haze = {random.uniform(0.4, 0.85), random.uniform(0.3, 0.8)};
  view.has_bound = false;
}

void near_the_edge(MovingView& view, test::Random& random) {
  view.at.distance_m = random.uniform(0.6, 1.2);
  view.at.off_axis_x_rad = random.uniform(17 * kDegree, 24 * kDegree) * (random.uniform(-1, 1) < 0 ? -1 : 1);
}

double light_between(const test::Exposure& exposure, double x, double y) {
  x = std::clamp(x, 0.0, exposure.width_px - 1.001), y = std::clamp(y, 0.0, exposure.height_px - 1.001);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double a = x - i, b = y - j;
  return (exposure.at(i, j) * (1 - a) + exposure.at(i + 1, j) * a) * (1 - b) +
         (exposure.at(i, j + 1) * (1 - a) + exposure.at(i + 1, j + 1) * a) * b;
}

}  // namespace

std::vector<ViewKind> view_kinds() {
  return {{"even light, 0.5 to 6 m", even_light},
          {"nearly frontal, 3 to 4.5 m", nearly_frontal},
          {"tilt 60 to 75 degrees", steep},
          {"hard shadow", hard_shadow},
          {"soft shadow", soft_shadow},
          {"striped shadow", striped_shadow},
          {"slope of light", slope_of_light},
          {"smoothly warped sheet", smooth_warp},
          {"bumpy sheet", bumpy_warp},
          {"40 % hidden", hidden<40>},
          {"50 % hidden", hidden<50>},
          {"60 % hidden", hidden<60>},
          {"partly out of the picture", near_the_edge},
          {"motion blur", motion_blur},
          {"roll of 15 to 25 degrees", rolled},
          {"low light", low_light},
          {"low light, ink 4 to 6 sigma", poor_light},
          {"haze", veiled}};
}

MovingView usual_view(test::Random& random) {
  MovingView view;
  view.at.distance_m = random.uniform(1, 3);
  view.at.tilt_rad = random.uniform(10 * kDegree, 45 * kDegree);
  view.at.azimuth_rad = random.uniform(-kHalfTurn_rad, kHalfTurn_rad);
  view.at.roll_rad = random.uniform(-10 * kDegree, 10 * kDegree);
  view.at.off_axis_x_rad = random.uniform(-8 * kDegree, 8 * kDegree);
  view.at.off_axis_y_rad = random.uniform(-6 * kDegree, 6 * kDegree);
  // Up to some 3 px per frame.
  view.per_frame = {random.uniform(-0.008, 0.008),
                    random.uniform(-0.2 * kDegree, 0.2 * kDegree),
                    random.uniform(-0.2 * kDegree, 0.2 * kDegree),
                    random.uniform(-0.2 * kDegree, 0.2 * kDegree),
                    random.uniform(-0.2 * kDegree, 0.2 * kDegree),
                    random.uniform(-0.1 * kDegree, 0.1 * kDegree)};
  view.scene.lens = trust_lens();
  view.scene.wall.seed = random.bits();
  view.scene.wall.reflectance = random.uniform(0.1, 0.6);
  view.scene.wall.contrast = random.uniform(0.05, 0.4);
  view.scene.light.level = random.uniform(0.6, 0.95);
  view.scene.sensor.point_spread_px = random.uniform(0.4, 0.8);
  test::set_noise(view.scene.sensor, random.uniform(1, 3));
  return view;
}

test::Scene scene_at(const MovingView& view, double frame) {
  test::Viewpoint at = view.at;
  at.distance_m += frame * view.per_frame.distance_m;
  at.tilt_rad += frame * view.per_frame.tilt_rad;
  at.azimuth_rad += frame * view.per_frame.azimuth_rad;
  at.roll_rad += frame * view.per_frame.roll_rad;
  at.off_axis_x_rad += frame * view.per_frame.off_axis_x_rad;
  at.off_axis_y_rad += frame * view.per_frame.off_axis_y_rad;
  test::Scene scene = view.scene;
  scene.camera = test::look_at_landmark(at);
  return scene;
}

test::Exposure smeared(const test::Exposure& exposure, double length_px, double direction_rad) {
  const int steps = std::max(1, static_cast<int>(std::ceil(2 * length_px)));
  test::Exposure result{exposure.width_px, exposure.height_px, {}};
  result.light.reserve(exposure.light.size());
  for (int y = 0; y < exposure.height_px; ++y)
    for (int x = 0; x < exposure.width_px; ++x) {
      double sum = 0;
      for (int i = 0; i < steps; ++i) {
        const double along_px = ((i + 0.5) / steps - 0.5) * length_px;
        sum += light_between(exposure, x + along_px * std::cos(direction_rad), y + along_px * std::sin(direction_rad));
      }
      result.light.push_back(sum / steps);
    }
  return result;
}

std::vector<Shot> shoot(const MovingView& view, int frames, std::uint64_t seed) {
  std::vector<Shot> shots;
  for (int frame = 0; frame < frames; ++frame) {
    const test::Scene scene = scene_at(view, frame);
    test::Exposure exposure = test::expose(scene);
    if (view.smear_px > 0) exposure = smeared(exposure, view.smear_px, view.smear_rad);
    Shot shot;
    shot.picture = test::read_out(exposure, scene.sensor, test::random_bits(seed, static_cast<std::uint64_t>(frame)));
    shot.truth = scene.camera;
    shot.at = frame * kFrameTime;
    if (view.has_bound && frame == 0)
      if (const auto bound = cramer_rao_bound(scene)) shot.bound_m = bound->position_m;
    shots.push_back(std::move(shot));
  }
  return shots;
}

}  // namespace ninedot::bench
