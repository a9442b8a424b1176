// Maps of large buildings: time, and errors over their sigmas. `./dev bench` runs it.
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <string>

#include "base/units.h"
#include "mapping/map_builder.h"
#include "tests/mapping/hall.h"

int main(int argc, char** argv) {
  using namespace ninedot;
  fmt::print(
      "landmarks  frames  sightings  seconds  placed  disagree  rms_mm  worst_mm  rms_deg  error/sigma  whole\n");
  for (const std::size_t count : {std::size_t{100}, std::size_t{300}, std::size_t{1000}}) {
    if (argc > 1 && std::to_string(count) != argv[1]) continue;
    test::HallOptions options;
    options.landmarks = count;
    options.frames = 15 * count;
    options.wrong_identities = 0.002;
    const test::Hall hall = test::make_hall(options);
    MapBuilderOptions build;
    build.exact = {1};
    const auto start = std::chrono::steady_clock::now();
    const BuiltMap map = build_map(hall.frames, hall.known(1), build);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    const test::MapScore score = test::score(map, hall.truth, 1);
    fmt::print("{:9}  {:6}  {:9}  {:7.1f}  {:6}  {:8}  {:6.2f}  {:8.2f}  {:7.4f}  {:11.2f}  {:5.2f}\n", count,
               hall.frames.size(), hall.sightings(), took.count(), map.placed.size(), map.disagreeing.size(),
               1000 * score.rms_m, 1000 * score.worst_m, score.rms_rad * kDegPerRad, score.axes, score.whole);
  }
}
