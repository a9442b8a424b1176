#include "tests/bench/trust/drawn.h"

#include <fmt/format.h>

#include "tests/bench/trust/effects.h"
#include "tests/bench/trust/near_misses.h"
#include "tests/bench/trust/views.h"

namespace ninedot::bench {
namespace {

std::uint64_t strip_seed(std::uint64_t seed, std::string_view kind, int index) {
  std::uint64_t mixed = seed;
  for (const char c : kind) mixed = test::random_bits(mixed, static_cast<unsigned char>(c));
  return test::random_bits(mixed, static_cast<std::uint64_t>(index));
}

std::string strip_name(std::uint64_t seed, int index) { return fmt::format("seed {} strip {}", seed, index); }

// Alone, or ten frames in a row.
struct Mode {
  const char* suffix;
  int frames;
  int strips(int pictures) const { return (pictures + frames - 1) / frames; }
};
constexpr std::array<Mode, 2> kModes{{{"", 1}, {", track", kTrackFrames}}};

class Drawn {
 public:
  Drawn(const std::function<bool(const Kind&)>& is_wanted, int frames, std::uint64_t seed)
      : is_wanted_(is_wanted), frames_(frames), seed_(seed) {}

  void add_near_misses() {
    for (const NearMiss& miss : near_misses()) {
      if (!add_kind("Near misses", miss.name)) continue;
      for (int i = 0; i < frames_; ++i)
        result_.jobs.emplace_back([miss, i, seed = seed_](const Taker& take) {
          Strip strip{miss.name, strip_name(seed, i), {}};
          strip.shots.push_back(draw_near_miss(miss, strip_seed(seed, miss.name, i)));
          take(std::move(strip));
        });
    }
  }

  /// Of each a quarter of the pictures, and others than those above.
  void add_near_misses_in_rooms() {
    const std::string name = "near misses, in a room";
    if (!add_kind("Near misses", name)) return;
    for (const NearMiss& miss : near_misses())
      for (int i = 0; i < (frames_ + 3) / 4; ++i)
        result_.jobs.emplace_back([miss, name, i, seed = seed_](const Taker& take) {
          const Shot shot = draw_near_miss(miss, strip_seed(seed, name + miss.name, i));
          take({name, fmt::format("{}, {}", miss.name, strip_name(seed, i)), seen_three_times(shot), true});
        });
  }

  void add_views() {
    for (const ViewKind& kind : view_kinds())
      for (const Mode& mode : kModes) {
        const std::string name = kind.name + std::string(mode.suffix);
        if (!add_kind("Views", name)) continue;
        for (int i = 0; i < mode.strips(frames_); ++i)
          result_.jobs.emplace_back([kind, mode, name, i, seed = seed_](const Taker& take) {
            const std::uint64_t own = strip_seed(seed, name, i);
            test::Random random(own);
            MovingView view = usual_view(random);
            kind.set(view, random);
            if (i % 4 != 0) view.has_bound = false;  // it takes twice the time of all the rest
            take({name, strip_name(seed, i), shoot(view, mode.frames, own)});
          });
      }
  }

  // All effects of one view in one job: drawing the view takes longer than they do.
  void add_effects() {
    for (const Mode& mode : kModes) {
      std::vector<Effect> wanted;
      for (const Effect& effect : effects())
        if (add_kind("Camera effects", effect.name + std::string(mode.suffix))) wanted.push_back(effect);
      for (int i = 0; i < (wanted.empty() ? 0 : mode.strips(frames_)); ++i)
        result_.jobs.emplace_back([wanted, mode, i, seed = seed_](const Taker& take) {
          const std::uint64_t own = strip_seed(seed, mode.suffix, i);
          test::Random random(own);
          const MovingView view = usual_view(random);
          std::vector<std::vector<Shot>> shots = shoot_through(wanted, view, mode.frames, own);
          for (std::size_t k = 0; k < wanted.size(); ++k)
            take({wanted[k].name + std::string(mode.suffix), strip_name(seed, i), std::move(shots[k])});
        });
    }
  }

  DrawnJobs take() { return std::move(result_); }

 private:
  bool add_kind(const char* group, const std::string& name) {
    const Kind kind{group, name};
    if (!is_wanted_(kind)) return false;
    result_.kinds.push_back(kind);
    return true;
  }

  const std::function<bool(const Kind&)>& is_wanted_;
  const int frames_;
  const std::uint64_t seed_;
  DrawnJobs result_;
};

}  // namespace

DrawnJobs drawn_jobs(const std::function<bool(const Kind&)>& is_wanted, int frames, std::uint64_t seed) {
  Drawn drawn(is_wanted, frames, seed);
  drawn.add_near_misses();
  drawn.add_near_misses_in_rooms();
  drawn.add_views();
  drawn.add_effects();
  return drawn.take();
}

}  // namespace ninedot::bench
