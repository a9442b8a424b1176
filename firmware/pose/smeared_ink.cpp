#include "pose/smeared_ink.h"

#include <algorithm>

#include "pose/blurred_disc.h"

namespace ninedot {

void gather_ink_of_others(const LandmarkGeometry& landmark, const OutlineState& state,
                          const DotContrasts& contrasts_lsb, OutlinePixels& pixels) noexcept {
  std::fill_n(pixels.ink_of_others_lsb.begin(), pixels.count, 0.0F);
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (!(contrasts_lsb[dot] > 0)) continue;
    const BlurredDisc disc(pixels, landmark, state, dot, Asked::kLightOnly);
    if (!disc.is_small()) continue;
    for (const OutlineGroup& group : pixels.groups) {
      if (!group.whole_dot || group.dot == dot) continue;
      const auto first = static_cast<std::size_t>(group.first), end = first + static_cast<std::size_t>(group.count);
      for (std::size_t at = first; at < end; at += kLanes) {
        const std::size_t used = std::min(kLanes, end - at);
        Lanes x, y, share;
        x.fill(pixels.ray_x[at]), y.fill(pixels.ray_y[at]);
        std::copy_n(pixels.ray_x.begin() + static_cast<std::ptrdiff_t>(at), used, x.begin());
        std::copy_n(pixels.ray_y.begin() + static_cast<std::ptrdiff_t>(at), used, y.begin());
        if (!disc.reaches_any(x, y)) continue;
        disc.ink_share(x, y, share);
        for (std::size_t l = 0; l < used; ++l) pixels.ink_of_others_lsb[at + l] += contrasts_lsb[dot] * share[l];
      }
    }
  }
}

}  // namespace ninedot
