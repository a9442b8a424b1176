#include "tests/bench/trust/effects.h"

#include <algorithm>
#include <cmath>

namespace ninedot::bench {
namespace {

test::Picture unchanged(const Taken& taken, test::Random&) { return taken.picture; }

template <int kQuality>
test::Picture jpeg(const Taken& taken, test::Random&) {
  return through_jpeg(taken.picture, kQuality);
}

template <int kPercent>
test::Picture sharpening(const Taken& taken, test::Random&) {
  return sharpened(taken.picture, kPercent / 100.0);
}

test::Picture median(const Taken& taken, test::Random&) { return median_of_nine(taken.picture); }

test::Picture denoising(const Taken& taken, test::Random& random) {
  return bilateral(taken.picture, 1.5, random.uniform(6, 18));
}

test::Picture denoising_and_sharpening(const Taken& taken, test::Random& random) {
  return sharpened(bilateral(taken.picture, 1.5, random.uniform(6, 18)), random.uniform(0.5, 1.2));
}

// Light through a disc, its edge smoothed over a pixel.
test::Picture defocus(const Taken& taken, test::Random& random) {
  const double radius_px = random.uniform(1.5, 3);
  constexpr int kReach = 4;
  const test::Exposure& sharp = taken.exposure;
  test::Exposure result{sharp.width_px, sharp.height_px, std::vector<double>(sharp.light.size())};
  double sum = 0;
  for (int dy = -kReach; dy <= kReach; ++dy)
    for (int dx = -kReach; dx <= kReach; ++dx) sum += std::clamp(radius_px - std::hypot(dx, dy) + 0.5, 0.0, 1.0);
  for (int dy = -kReach; dy <= kReach; ++dy)
    for (int dx = -kReach; dx <= kReach; ++dx) {
      const double weight = std::clamp(radius_px - std::hypot(dx, dy) + 0.5, 0.0, 1.0) / sum;
      if (weight == 0) continue;
      for (int y = 0; y < sharp.height_px; ++y)
        for (int x = 0; x < sharp.width_px; ++x)
          result.light[static_cast<std::size_t>(y * sharp.width_px + x)] +=
              weight * sharp.at(std::clamp(x + dx, 0, sharp.width_px - 1), std::clamp(y + dy, 0, sharp.height_px - 1));
    }
  return test::read_out(result, taken.sensor, taken.seed);
}

// factor(x, y): what becomes of the light.
template <typename Factor>
test::Picture lit(const Taken& taken, const Factor& factor) {
  test::Exposure exposure = taken.exposure;
  for (int y = 0; y < exposure.height_px; ++y)
    for (int x = 0; x < exposure.width_px; ++x)
      exposure.light[static_cast<std::size_t>(y * exposure.width_px + x)] *= factor(x, y);
  return test::read_out(exposure, taken.sensor, taken.seed);
}

test::Picture over_exposure(const Taken& taken, test::Random& random) {
  const double factor = random.uniform(1.5, 4);
  return lit(taken, [&](int, int) { return factor; });
}

// cos^4 and more: up to three quarters of the light are missing in the corners.
test::Picture vignetting(const Taken& taken, test::Random& random) {
  const double loss = random.uniform(0.4, 1);
  return lit(taken, [&](int x, int y) {
    const double radius = std::hypot(x - 319.5, y - 239.5) / 400;
    return 1 / std::pow(1 + loss * radius * radius, 2);
  });
}

// level(index) -> another level; row by row.
template <typename Level>
test::Picture changed(const test::Picture& picture, const Level& level) {
  test::Picture result = picture;
  for (std::size_t i = 0; i < result.pixels.size(); ++i)
    result.pixels[i] = static_cast<std::uint8_t>(std::clamp(level(i) + 0.5, 0.0, 255.0));
  return result;
}

test::Picture gamma_curve(const Taken& taken, test::Random& random) {
  const double gamma = std::exp(random.uniform(std::log(0.5), std::log(2.0)));
  return changed(taken.picture, [&](std::size_t i) { return 255 * std::pow(taken.picture.pixels[i] / 255.0, gamma); });
}

// A curve that is steep in the middle, as cameras make pictures look crisp.
test::Picture contrast_curve(const Taken& taken, test::Random& random) {
  const double steep = random.uniform(3, 9), middle = random.uniform(0.35, 0.65);
  const auto curve = [&](double t) { return 1 / (1 + std::exp(-steep * (t - middle))); };
  return changed(taken.picture, [&](std::size_t i) {
    return 255 * (curve(taken.picture.pixels[i] / 255.0) - curve(0)) / (curve(1) - curve(0));
  });
}

test::Picture five_bits(const Taken& taken, test::Random&) {
  return changed(taken.picture, [&](std::size_t i) { return 8.0 * (taken.picture.pixels[i] / 8) + 3.5; });
}

test::Picture row_noise(const Taken& taken, test::Random& random) {
  const double sigma_lsb = random.uniform(1.5, 4);
  const auto width = static_cast<std::size_t>(taken.picture.width_px);
  return changed(taken.picture, [&](std::size_t i) {
    return taken.picture.pixels[i] + sigma_lsb * test::random_normal(~taken.seed, i / width);
  });
}

test::Picture hot_pixels(const Taken& taken, test::Random& random) {
  const std::uint64_t places = random.bits();  // they stay where they are
  const double share = random.uniform(0.0002, 0.003);
  return changed(taken.picture, [&](std::size_t i) {
    const bool hot = test::random_uniform(places, 2 * i) < share;
    return hot ? 255 * test::random_uniform(places, 2 * i + 1) : taken.picture.pixels[i];
  });
}

test::Picture interlacing(const Taken& taken, test::Random&) {
  const test::Picture later = test::read_out(taken.later, taken.sensor, ~taken.seed);
  const auto width = static_cast<std::size_t>(taken.picture.width_px);
  return changed(taken.picture, [&](std::size_t i) {
    return static_cast<double>(i / width % 2 == 0 ? taken.picture.pixels[i] : later.pixels[i]);
  });
}

// Half the rows and columns, and the rest made up between them: binning, digital zoom, another camera's mode.
test::Picture scaled_up(const Taken& taken, test::Random&) {
  const test::Picture& p = taken.picture;
  const auto half = [&](int x, int y) {
    x = std::clamp(x, 0, p.width_px / 2 - 1), y = std::clamp(y, 0, p.height_px / 2 - 1);
    const ImageView v = p.view();
    return (v.at(2 * x, 2 * y) + v.at(2 * x + 1, 2 * y) + v.at(2 * x, 2 * y + 1) + v.at(2 * x + 1, 2 * y + 1)) / 4.0;
  };
  const auto width = static_cast<std::size_t>(p.width_px);
  return changed(p, [&](std::size_t i) {
    const int x = static_cast<int>(i % width), y = static_cast<int>(i / width);
    const int nx = x / 2 + (x % 2 == 0 ? -1 : 1), ny = y / 2 + (y % 2 == 0 ? -1 : 1);
    return (9 * half(x / 2, y / 2) + 3 * half(nx, y / 2) + 3 * half(x / 2, ny) + half(nx, ny)) / 16;
  });
}

}  // namespace

std::vector<Effect> effects() {
  return {{"no effect", unchanged},
          {"JPEG, quality 75", jpeg<75>},
          {"JPEG, quality 45", jpeg<45>},
          {"sharpening by 60 %", sharpening<60>},
          {"sharpening by 150 %", sharpening<150>},
          {"median of 3 x 3", median},
          {"denoising", denoising},
          {"denoising, then sharpening", denoising_and_sharpening},
          {"defocus, disc of 1.5 to 3 px", defocus},
          {"over-exposure", over_exposure},
          {"vignetting", vignetting},
          {"gamma of 0.5 to 2", gamma_curve},
          {"steep tone curve", contrast_curve},
          {"5 bits", five_bits},
          {"row noise", row_noise},
          {"hot pixels", hot_pixels},
          {"scaled up from half size", scaled_up},
          {"interlacing", interlacing, true}};
}

std::vector<std::vector<Shot>> shoot_through(const std::vector<Effect>& wanted, const MovingView& view, int frames,
                                             std::uint64_t seed) {
  std::vector<std::vector<Shot>> shots(wanted.size());
  const bool needs_later =
      std::any_of(wanted.begin(), wanted.end(), [](const Effect& effect) { return effect.needs_later; });
  for (int frame = 0; frame < frames; ++frame) {
    const test::Scene scene = scene_at(view, frame);
    const test::Exposure exposure = test::expose(scene);
    const test::Exposure later = needs_later ? test::expose(scene_at(view, frame + 0.5)) : test::Exposure{};
    const std::uint64_t noise_seed = test::random_bits(seed, static_cast<std::uint64_t>(frame));
    const test::Picture picture = test::read_out(exposure, scene.sensor, noise_seed);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      test::Random random(seed);
      Shot shot;
      shot.picture = wanted[i].apply({exposure, later, scene.sensor, picture, noise_seed}, random);
      shot.truth = wanted[i].needs_later ? scene_at(view, frame + 0.25).camera : scene.camera;
      shot.at = frame * kFrameTime;
      shots[i].push_back(std::move(shot));
    }
  }
  return shots;
}

}  // namespace ninedot::bench
