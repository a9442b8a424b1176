// The second part of docs/accuracy.md: walks through rooms.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/bench/accuracy_report.h"

namespace ninedot::bench {
namespace {

std::string percent(int part, int whole) { return fmt::format("{:.0f}", 100.0 * part / std::max(1, whole)); }

/// \param bounded  with the column of errors over the bound
std::string place_columns(const PlaceOutcome& place, bool bounded) {
  if (place.frames == place.wrong) return bounded ? " - | - | - |" : " - | - |";
  const std::string ratio = bounded ? fmt::format(" {} |", three_digits(place.ratio)) : "";
  return fmt::format(" {} |{} {} |", three_digits(1000 * place.rms_m), ratio, three_digits(place.per_sigma));
}

std::string table(const RoomSweep& sweep) {
  std::string text = fmt::format(
      "| {} | shown | found % | identified % | wrong | bound mm | rows % | world mm | x bound | per sigma "
      "| track % | track mm | per sigma | wrong places |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      sweep.varied);
  for (std::size_t i = 0; i < sweep.conditions.size(); ++i) {
    const RoomOutcome& o = sweep.outcomes[i];
    text +=
        fmt::format("| {} | {} | {} | {} | {} | {} | {} |{} {} |{} {} |\n", sweep.conditions[i].label, o.shown,
                    percent(o.found, o.shown), percent(o.identified, o.shown), o.wrong, three_digits(1000 * o.bound_m),
                    percent(o.world.frames, o.frames), place_columns(o.world, true), percent(o.track.frames, o.frames),
                    place_columns(o.track, false), o.world.wrong + o.track.wrong);
  }
  return text;
}

std::string headline(const std::vector<RoomSweep>& sweeps) {
  RoomOutcome sum;
  std::vector<double> ratios;
  double world_per_sigma = 0, track_per_sigma = 0;
  for (const RoomSweep& sweep : sweeps)
    for (const RoomOutcome& o : sweep.outcomes) {
      sum.frames += o.frames, sum.shown += o.shown, sum.identified += o.identified, sum.wrong += o.wrong;
      const int world = o.world.frames - o.world.wrong, track = o.track.frames - o.track.wrong;
      world_per_sigma += world * o.world.per_sigma * o.world.per_sigma, sum.world.frames += world;
      track_per_sigma += track * o.track.per_sigma * o.track.per_sigma, sum.track.frames += track;
      sum.world.wrong += o.world.wrong + o.track.wrong;
      if (world > 0) ratios.push_back(o.world.ratio);
    }
  std::ranges::sort(ratios);
  return fmt::format(
      "**In {} frames that show {} landmarks, {} % of these are identified and {} reported wrongly; {} % of the frames "
      "have a\nplace in the world, {} of all places, by frame or track, are wrong. The error of a frame's place is {} "
      "to "
      "{} times the\nbound of all its landmarks together (medians of rows; half of them below {}), and {} of its "
      "stated "
      "sigma (root mean\nsquare); the track's is {} of its own.**\n\n",
      sum.frames, sum.shown, percent(sum.identified, sum.shown), sum.wrong, percent(sum.world.frames, sum.frames),
      sum.world.wrong, three_digits(ratios.front()), three_digits(ratios.back()),
      three_digits(ratios[ratios.size() / 2]), three_digits(std::sqrt(world_per_sigma / sum.world.frames)),
      three_digits(std::sqrt(track_per_sigma / sum.track.frames)));
}

std::string conditions() {
  return fmt::format(
      R"(Made by `build/release/bin/accuracy --only rooms --out docs/accuracy.md`: {0} walks of {1} frames a row, 35 a second, each
through another room, the same ones in all rows, from picture to place as `ninedot replay --out-world --out-track` goes,
with the map's places exact. Where a table does not say otherwise: a room of 12 m by 8 m, twelve coded landmarks along one
wall, 0.8 m from one to the next, four on another, posters between them, a lamp; a camera of fx = fy = 720 px, 640 x 480,
that goes by 2 m from the wall at 1 m/s, looks 25 degrees ahead and turns its head by 12 degrees to either side. 4 ms of
exposure, a rolling shutter of 16 ms that the configuration knows of (`row_time_us`), RGGB, 4:2:0, noise of 2 grey levels
at level 128, light of 5000 K.

- *shown*: landmarks wholly in the picture with ring dots of 2.2 px or more across, all frames of the row together.
  *found*: by a search of the whole picture that knows of no other frame; *identified*: reported under their own numbers,
  followed from frame to frame or where the map lets expect them; *wrong*: reported as valid without being so.
- *bound*: of the camera's place by all landmarks shown together ([tests/bench/room_bound.h](../tests/bench/room_bound.h)),
  each with even light and at rest, seen by a camera without a Bayer pattern; root mean square.
- *rows*: frames with a place in the world by themselves; *track*: with one by all frames up to then. *mm*: root mean
  square errors of the position; *x bound*: median of each error over its own frame's bound (of an efficient estimator
  0.8 to 0.95; less in a track, which has more than one frame). *per sigma*: errors over their stated 1-sigma, root mean
  square over the axes; 1 is honest, more is overconfident.
- *wrong places*: off by more than a tenth of the distance to the nearest landmark; left out of the columns before.
- Frames of a walk hang together: a row's figures are uncertain by some 20 %.

)",
      kRoomWalks, kRoomFrames);
}

}  // namespace

std::string rooms_part(const std::vector<RoomSweep>& sweeps) {
  std::string part = fmt::format("{}\n{}{}", kRoomsHeading, headline(sweeps), conditions());
  for (const RoomSweep& sweep : sweeps) {
    part += fmt::format("### {}\n\n", sweep.heading);
    if (!sweep.note.empty()) part += sweep.note + "\n\n";
    if (!sweep.name.empty())
      part += fmt::format("![Position error over {}: joint bound, world, track](accuracy-{}.svg)\n\n", sweep.varied,
                          sweep.name);
    part += table(sweep) + "\n";
  }
  part.pop_back();
  return part;
}

}  // namespace ninedot::bench
