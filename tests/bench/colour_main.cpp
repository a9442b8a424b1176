/// bench_colour FOLDER... [--chroma full|422|420] [--extra N] [--error-px 0.3] [--black] [--upright] [--views]: colour
/// codes read in recordings with truth, the true poses moved by an error. The map is the folder's map.toml, or else the
/// known codes, and N random ones. A table by the short axis of the ring's dots: views, those identified (all else
/// together at most 1 %), those that are identified as another one or with another turn, those taken for another one
/// when the map lacks theirs; letters; and how often four frames of watching speak for the landmark, and against the
/// map's next one in its place. Exit status: 0 measured, 2 could not measure.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "base/startup_error.h"
#include "colour/code_reader.h"
#include "colour/disc_picture.h"
#include "tests/bench/case_folder.h"
#include "tests/support/random.h"
#include "world/landmark_codes.h"

namespace {

using namespace ninedot;
using namespace ninedot::bench;

struct Options {
  std::vector<std::string> folders;
  std::string chroma = "full";
  std::size_t extra = 0;
  double error_px = 0.3;
  bool black = false;
  bool upright = false;
  bool per_view = false;
};

constexpr double kMostOdds = 0.01;  // the rule for acting on anything
constexpr std::array<double, 7> kSizes_px{0, 2.5, 3, 4, 6, 10, 1000};

struct Tally {
  int views = 0, identified = 0, wrong = 0, foreign_wrong = 0;
  int letters_sure = 0, letters_wrong = 0;
  int kept = 0, replaced = 0;  // by watching: the landmark itself, another in its place
};
using Tallies = std::array<Tally, kSizes_px.size() - 1>;

/// A folder with what its landmarks are called.
struct Plant {
  CaseFolder folder;
  std::vector<MappedLandmark> landmarks;
};

/// One landmark in one picture.
struct View {
  const Plant& plant;
  const CaseFrame& frame;
  std::size_t own = 0;  // index of the landmark
  double size_px = 0;   // short axis of its ring's dots
  CameraFromLandmark T;
  ChromaView chroma;
  const PictureNoise& noise;
};

/// Lines `id = N` and `code = "..."`; without a map, the known codes.
std::vector<MappedLandmark> read_codes(const std::string& folder) {
  std::vector<MappedLandmark> landmarks;
  std::ifstream file(folder + "/map.toml");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("id = ")) landmarks.emplace_back().id = static_cast<std::uint16_t>(std::stoi(line.substr(5)));
    if (line.starts_with("code = ") && !landmarks.empty()) landmarks.back().code = line.substr(8, kRingDotCount);
  }
  if (!landmarks.empty()) return landmarks;
  for (int id = 0; id <= 5; ++id)
    landmarks.push_back({static_cast<std::uint16_t>(id), std::string(known_code(id).value()), {}});
  return landmarks;
}

void add_random_codes(std::size_t count, std::vector<MappedLandmark>& landmarks) {
  test::Random random(7);
  while (count > 0) {
    std::string code;
    for (std::size_t i = 0; i < kRingDotCount; ++i) code += kInkLetters[random.bits() % kInkCount];
    const bool known =
        std::ranges::any_of(landmarks, [&](const auto& other) { return code_distance(code, other.code).places == 0; });
    if (known || own_distance(code).places == 0) continue;
    landmarks.push_back({static_cast<std::uint16_t>(landmarks.size() + 1000), code, {}});
    --count;
  }
}

/// Chroma as a camera hands it over: means over blocks of pixels.
struct Subsampled {
  std::vector<std::uint8_t> bytes;
  ChromaView view;
};
Subsampled subsample(const ChromaView& chroma, int columns, int rows) {
  Subsampled out;
  const int width = chroma.width / columns, height = chroma.height / rows, count = columns * rows;
  out.bytes.reserve(static_cast<std::size_t>(2 * width * height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      int cb = count / 2, cr = count / 2;
      for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
          cb += chroma.cb_at(x * columns + i, y * rows + j), cr += chroma.cr_at(x * columns + i, y * rows + j);
      out.bytes.push_back(static_cast<std::uint8_t>(cb / count));
      out.bytes.push_back(static_cast<std::uint8_t>(cr / count));
    }
  out.view = {out.bytes.data(), out.bytes.data() + 1, width, height, 2, 2 * width};
  return out;
}

/// The sheet seen error_px aside, larger or smaller by that, and tilted a little.
CameraFromLandmark moved(CameraFromLandmark T, double fx_px, double error_px, test::Random& random) {
  const double m_per_px = T.translation_m.z() / fx_px;
  const double ring_px = LandmarkGeometry{}.ring_radius_m / m_per_px;
  T.translation_m += error_px * m_per_px * Eigen::Vector3d(random.normal(), random.normal(), 0);
  T.translation_m *= 1 + error_px / ring_px * random.normal();
  const Eigen::Vector3d turn_rad(random.normal(), random.normal(), random.normal());
  T.rotation = exp_so3(error_px / ring_px * turn_rad) * T.rotation;
  return T;
}

void count_letters(const std::string& letters, const std::string& code, Tally& tally) {
  for (std::size_t place = 0; place < letters.size(); ++place) {
    tally.letters_sure += letters[place] != '?';
    tally.letters_wrong += letters[place] != '?' && letters[place] != (code.empty() ? 'K' : code[place]);
  }
}

/// Of a camera that stands upright, its roll known to 5 degrees: the nearest other turns are 9 sigma away.
constexpr TurnCosts kUpright{0, 81, 324, 729, 1296, 729, 324, 81};

void identify(const View& view, const DotColours& colours, const CodeReader& codes, const Options& options,
              Tally& tally) {
  const TurnCosts turn_costs = options.upright ? kUpright : TurnCosts{};
  const CodeReading reading = codes.decode(colours, turn_costs);
  const bool right = reading.best && reading.best->landmark == view.own && reading.best->turn == 0;
  const bool sure = reading.odds_of_others <= kMostOdds;
  ++tally.views;
  tally.identified += sure && right;
  tally.wrong += sure && !right;
  const MappedLandmark& landmark = view.plant.landmarks[view.own];
  std::string letters;
  for (std::size_t place = 0; place < kRingDotCount; ++place) letters += colours.letter(place);
  count_letters(letters, landmark.code, tally);
  std::vector<MappedLandmark> others = view.plant.landmarks;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(view.own));
  tally.foreign_wrong += CodeReader(others).decode(colours, turn_costs).odds_of_others <= kMostOdds;
  if (options.per_view)
    fmt::print("{} {:3} id {:2} {:5.1f} px {} read {} {} others {:.2g} none {:.2g}\n", view.plant.folder.name,
               view.frame.number, landmark.id, view.size_px, landmark.code, letters,
               sure ? (right ? "right" : "WRONG") : "-", reading.odds_of_others, reading.odds_of_none);
}

/// Against a landmark, by the four frames in which all its places are watched.
double watched_evidence(const View& view, const ColourReader& reader, const CodeReader& codes, std::size_t landmark) {
  double evidence = 1;
  for (std::uint64_t frame = 0; frame < kRingDotCount / 2; ++frame)
    evidence *= codes.evidence_against(
        landmark, 0, reader.watch(view.plant.folder.view(view.frame), view.chroma, view.T, view.noise, frame));
  return evidence;
}

std::size_t size_class(double size_px) {
  return static_cast<std::size_t>(std::ranges::upper_bound(kSizes_px, size_px) - kSizes_px.begin() - 1);
}

void measure_folder(const std::string& path, const Options& options, Tallies& tallies) {
  Plant plant{read_case(path), read_codes(path)};
  add_random_codes(options.extra, plant.landmarks);
  if (options.black) plant.landmarks.push_back({9999, "", {}});
  const CameraModel& camera = plant.folder.camera;
  const ColourReader reader(camera, LandmarkGeometry{});
  const CodeReader codes(plant.landmarks);
  test::Random random(1);
  for (const CaseFrame& frame : plant.folder.frames) {
    if (frame.chroma.empty()) continue;
    const ImageView luma = plant.folder.view(frame);
    const PictureNoise noise(luma);
    const Subsampled colour =
        subsample(frame.chroma, options.chroma == "full" ? 1 : 2, options.chroma == "420" ? 2 : 1);
    for (const TruePose& truth : frame.landmarks) {
      const auto own = std::ranges::find(plant.landmarks, truth.landmark_id, [](const auto& l) { return int{l.id}; });
      if (own == plant.landmarks.end()) continue;
      const CameraFromLandmark T_true = truth.T_landmark_camera.inverse();
      const DiscPicture dot = disc_in_picture(T_true, camera, {0, 0}, LandmarkGeometry{}.dot_radius_m);
      const View view{plant,
                      frame,
                      static_cast<std::size_t>(own - plant.landmarks.begin()),
                      2 * static_cast<double>(dot.semi_minor_px),
                      moved(T_true, camera.fx_px, options.error_px, random),
                      colour.view,
                      noise};
      Tally& tally = tallies[size_class(view.size_px)];
      identify(view, reader.read(luma, view.chroma, view.T, noise), codes, options, tally);
      tally.kept += watched_evidence(view, reader, codes, view.own) < 1;
      tally.replaced += watched_evidence(view, reader, codes, (view.own + 1) % plant.landmarks.size()) > 1;
    }
  }
}

int measure(const Options& options) {
  Tallies tallies{};
  for (const std::string& folder : options.folders) measure_folder(folder, options, tallies);
  fmt::print(
      "| short axis px | views | identified % | wrong | wrong if not in the map | letters sure % | of these wrong % "
      "| watched: kept % | another noticed % |\n|---|---|---|---|---|---|---|---|---|\n");
  for (std::size_t i = 0; i < tallies.size(); ++i) {
    const Tally& t = tallies[i];
    if (t.views == 0) continue;
    fmt::print("| {} to {} | {} | {:.1f} | {} | {} | {:.1f} | {:.2f} | {:.1f} | {:.1f} |\n", kSizes_px[i],
               kSizes_px[i + 1], t.views, 100.0 * t.identified / t.views, t.wrong, t.foreign_wrong,
               100.0 * t.letters_sure / (kRingDotCount * static_cast<double>(t.views)),
               100.0 * t.letters_wrong / std::max(1, t.letters_sure), 100.0 * t.kept / t.views,
               100.0 * t.replaced / t.views);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const bool more = i + 1 < argc;
    if (word == "--views")
      options.per_view = true;
    else if (word == "--black")
      options.black = true;
    else if (word == "--upright")
      options.upright = true;
    else if (word == "--chroma" && more)
      options.chroma = argv[++i];
    else if (word == "--extra" && more)
      options.extra = static_cast<std::size_t>(std::atoi(argv[++i]));
    else if (word == "--error-px" && more)
      options.error_px = std::atof(argv[++i]);
    else
      options.folders.emplace_back(word);
  }
  try {
    return measure(options);
  } catch (const StartupError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
