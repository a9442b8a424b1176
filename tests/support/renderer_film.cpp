#include "tests/support/renderer_film.h"

#include <algorithm>
#include <cmath>

namespace ninedot::test {

Spread::Spread(double sigma_px, int samples)
    : samples_(samples), reach_(static_cast<int>(std::ceil(0.5 + 4 * sigma_px))) {
  const auto step = [&](double d_px) {
    return sigma_px > 0 ? 0.5 * std::erfc(-d_px / (sigma_px * std::sqrt(2.0))) : (d_px > 0 ? 1.0 : 0.0);
  };
  weights_.resize(static_cast<std::size_t>((2 * reach_ + 1) * samples_));
  for (int i = 0; i < samples_; ++i) {
    double sum = 0;
    for (int pixel = -reach_; pixel <= reach_; ++pixel) {
      const double d_px = (i + 0.5) / samples_ - 0.5 - pixel;
      sum += weights_[index(pixel, i)] = step(d_px + 0.5) - step(d_px - 0.5);
    }
    for (int pixel = -reach_; pixel <= reach_; ++pixel) weights_[index(pixel, i)] /= sum * samples_;
  }
}

Film::Film(int width_px, int height_px, const Spread& spread)
    : spread_(spread),
      exposure_{width_px, height_px, {}},
      column_(static_cast<std::size_t>((2 * spread.reach() + 1) * spread.samples())) {
  exposure_.light.resize(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
}

void Film::add(int x, int y, std::span<const double> samples) {
  const int reach = spread_.reach(), side = spread_.samples();
  for (int dx = -reach; dx <= reach; ++dx)
    for (int j = 0; j < side; ++j) {
      double sum = 0;
      for (int i = 0; i < side; ++i) sum += spread_.weight(dx, i) * samples[static_cast<std::size_t>(j * side + i)];
      column_[static_cast<std::size_t>((dx + reach) * side + j)] = sum;
    }
  for (int dy = std::max(-reach, -y); dy <= std::min(reach, exposure_.height_px - 1 - y); ++dy)
    for (int dx = std::max(-reach, -x); dx <= std::min(reach, exposure_.width_px - 1 - x); ++dx) {
      double sum = 0;
      for (int j = 0; j < side; ++j)
        sum += spread_.weight(dy, j) * column_[static_cast<std::size_t>((dx + reach) * side + j)];
      exposure_.light[static_cast<std::size_t>((y + dy) * exposure_.width_px + x + dx)] += sum;
    }
}

void Film::add_flat(const std::vector<double>& cells) {
  const int reach = spread_.reach(), width = exposure_.width_px, height = exposure_.height_px,
            stride = width + 2 * reach;
  std::vector<double> whole(static_cast<std::size_t>(2 * reach + 1));
  for (int d = -reach; d <= reach; ++d)
    for (int i = 0; i < spread_.samples(); ++i) whole[static_cast<std::size_t>(d + reach)] += spread_.weight(d, i);
  std::vector<double> rows(static_cast<std::size_t>((height + 2 * reach) * width));
  for (int y = 0; y < height + 2 * reach; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int d = 0; d <= 2 * reach; ++d)
        sum += whole[static_cast<std::size_t>(d)] * cells[static_cast<std::size_t>(y * stride + x + d)];
      rows[static_cast<std::size_t>(y * width + x)] = sum;
    }
  for (int d = 0; d <= 2 * reach; ++d)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        exposure_.light[static_cast<std::size_t>(y * width + x)] +=
            whole[static_cast<std::size_t>(d)] * rows[static_cast<std::size_t>((y + d) * width + x)];
}

}  // namespace ninedot::test
