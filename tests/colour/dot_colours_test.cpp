// Letters and codes from rendered pictures whose inks the reader's prototypes were not drawn up from: what screens and
// presses take for red, green, blue and black.
#include "colour/dot_colours.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "colour/code_reader.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/colour_renderer.h"
#include "tests/support/random.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

using test::ChromaLayout;
using test::ColourPicture;
using test::ColourScene;
using test::LinearRgb;

constexpr double kMostOdds = 0.01;  // of all but the chosen one: above it nothing is acted on
constexpr double kDeg = std::numbers::pi / 180;

/// sRGB values of the usual swatches: process inks (Adobe's CMYK defaults), screens' primaries, deep and light ones.
struct Swatch {
  int red, green, blue;
};
constexpr std::array<Swatch, 4> kBlacks{{{35, 31, 32}, {20, 20, 20}, {40, 40, 52}, {48, 42, 38}}};
constexpr std::array<Swatch, 6> kReds{
    {{237, 28, 36}, {200, 30, 30}, {241, 90, 36}, {190, 30, 60}, {220, 40, 90}, {230, 0, 0}}};
constexpr std::array<Swatch, 6> kGreens{
    {{0, 166, 81}, {0, 130, 60}, {57, 181, 74}, {0, 146, 100}, {0, 150, 0}, {100, 170, 50}}};
constexpr std::array<Swatch, 6> kBlues{
    {{46, 49, 146}, {0, 0, 200}, {0, 113, 188}, {30, 60, 150}, {20, 30, 135}, {70, 60, 170}}};

/// With what the surface reflects without going through the ink.
LinearRgb paint(const Swatch& swatch) {
  constexpr double kSurface = 0.02;
  const LinearRgb ink = test::linear_of_srgb(swatch.red, swatch.green, swatch.blue);
  return {kSurface + 0.88 * ink.red, kSurface + 0.88 * ink.green, kSurface + 0.88 * ink.blue};
}

/// One box of inks: which swatch each letter is printed with.
struct Inks {
  Swatch black = kBlacks[0], red = kReds[0], green = kGreens[0], blue = kBlues[0];

  static Inks any(test::Random& random) {
    return {kBlacks[random.bits() % kBlacks.size()], kReds[random.bits() % kReds.size()],
            kGreens[random.bits() % kGreens.size()], kBlues[random.bits() % kBlues.size()]};
  }
  LinearRgb of(char letter) const {
    return paint(letter == 'R' ? red : letter == 'G' ? green : letter == 'B' ? blue : black);
  }
};

/// A small picture around the landmark, dots of the ring `dot_px` in diameter.
ColourScene scene_of(const std::string& code, double dot_px, const Inks& inks = {}, double tilt_rad = 20 * kDeg) {
  ColourScene colours;
  test::Scene& scene = colours.scene;
  const LandmarkGeometry landmark;
  const double distance_m = scene.lens.fx_px * 2 * landmark.dot_radius_m / dot_px;
  const int side_px = 2 * static_cast<int>(0.16 / distance_m * scene.lens.fx_px);
  scene.lens.width_px = scene.lens.height_px = side_px;
  scene.lens.cx_px = scene.lens.cy_px = (side_px - 1) / 2.0;
  scene.camera = test::look_at_landmark({.distance_m = distance_m, .tilt_rad = tilt_rad});
  test::set_noise(scene.sensor, 2);
  for (const char letter : code) colours.discs.push_back(inks.of(letter));
  colours.discs.push_back(inks.of('K'));
  return colours;
}

CameraFromLandmark pose_of(const test::Scene& scene) {
  Transform<frame::Landmark, frame::Camera> T;
  const auto& q = scene.camera.quaternion_wxyz;
  T.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  T.translation_m = Eigen::Vector3d(scene.camera.position_m.data());
  return T.inverse();
}

CameraModel camera_of(const ColourScene& scene) {
  CameraModel camera;
  const test::Lens& lens = scene.scene.lens;
  camera.width_px = lens.width_px, camera.height_px = lens.height_px;
  camera.fx_px = lens.fx_px, camera.fy_px = lens.fy_px, camera.cx_px = lens.cx_px, camera.cy_px = lens.cy_px;
  return camera;
}

DotColours colours_of(const ColourScene& scene, const ColourPicture& picture) {
  return ColourReader(camera_of(scene), LandmarkGeometry{})
      .read(picture.luma.view(), picture.chroma(), pose_of(scene.scene), PictureNoise(picture.luma.view()));
}

DotColours colours_of(const ColourScene& scene, std::uint64_t seed, ChromaLayout layout = ChromaLayout::k420) {
  return colours_of(scene, test::render_colour(scene, layout, seed));
}

std::string letters_of(const DotColours& colours) {
  std::string letters;
  for (std::size_t place = 0; place < kRingDotCount; ++place) letters += colours.letter(place);
  return letters;
}

std::vector<MappedLandmark> known_landmarks() {
  std::vector<MappedLandmark> landmarks;
  for (int id = 0; id <= 5; ++id)
    landmarks.push_back({static_cast<std::uint16_t>(id), std::string(known_code(id).value()), {}});
  return landmarks;
}

struct Score {
  int views = 0, identified = 0, wrong = 0;

  void add(const CodeReading& reading, std::size_t landmark) {
    ++views;
    if (reading.odds_of_others > kMostOdds) return;
    const bool right = reading.best->landmark == landmark && reading.best->turn == 0;
    identified += right, wrong += !right;
  }
};

/// Views of all known landmarks, each with inks, light and faults of its own.
template <typename Change>
Score score_of(double dot_px, int views, std::uint64_t seed, Change&& change) {
  const std::vector<MappedLandmark> landmarks = known_landmarks();
  const CodeReader reader(landmarks);
  test::Random random(seed);
  Score score;
  for (int i = 0; i < views; ++i) {
    const std::size_t landmark = 1 + random.bits() % 5;
    ColourScene scene = scene_of(landmarks[landmark].code, dot_px, Inks::any(random), random.uniform(0, 45) * kDeg);
    change(scene, random);
    const DotColours colours = colours_of(scene, random.bits());
    const CodeReading reading = reader.decode(colours);
    score.add(reading, landmark);
  }
  return score;
}

void light_by(double kelvin, ColourScene& scene) {
  scene.light = test::light_of_kelvin(kelvin);
  const double most = std::max({scene.light.red, scene.light.green, scene.light.blue});
  scene.light.red /= most, scene.light.green /= most, scene.light.blue /= most;
}

TEST(DotColours, ReadsEveryLetterOfLargeDots) {
  for (const ChromaLayout layout : {ChromaLayout::k444, ChromaLayout::k422, ChromaLayout::k420})
    EXPECT_EQ(letters_of(colours_of(scene_of("KRGBKKRB", 20), 1, layout)), "KRGBKKRB");
}

TEST(DotColours, IdentifiesLandmarksOfInksThatItWasNotMadeFor) {
  for (const double dot_px : {3.4, 4.5, 6.0, 12.0}) {
    const Score score = score_of(dot_px, 20, 1, [](auto&, auto&) {});
    EXPECT_GE(score.identified, 19) << dot_px;
    EXPECT_EQ(score.wrong, 0) << dot_px;
  }
}

/// Where the dots fall on the sensor's pattern, which is the same in the middle of every picture.
void put_anywhere(ColourScene& scene, test::Random& random) {
  scene.scene.lens.cx_px += random.uniform(-1, 1);
  scene.scene.lens.cy_px += random.uniform(-1, 1);
}

/// One by one 0 and 41 of 100 are, together 51 and 85: there is a block or two of paper around each, and none on the
/// side of the wall.
TEST(DotColours, IdentifiesLandmarksOfDotsTooSmallForPaperOfTheirOwn) {
  for (const auto& [dot_px, least] : {std::pair{2.4, 40}, {2.7, 75}}) {
    const Score score = score_of(dot_px, 100, 8, put_anywhere);
    EXPECT_GE(score.identified, least) << dot_px;
    EXPECT_EQ(score.wrong, 0) << dot_px;
  }
}

TEST(DotColours, IdentifiesLandmarksInLightFrom2700To9000Kelvin) {
  const Score score = score_of(5, 30, 2, [](ColourScene& scene, test::Random& random) {
    light_by(1 / random.uniform(1 / 9000.0, 1 / 2700.0), scene);
  });
  EXPECT_GE(score.identified, 29);
  EXPECT_EQ(score.wrong, 0);
}

TEST(DotColours, IdentifiesFadedPrintsUpToHalfPaper) {
  const Score score =
      score_of(5, 30, 3, [](ColourScene& scene, test::Random& random) { scene.fade = random.uniform(0, 0.5); });
  EXPECT_GE(score.identified, 29);
  EXPECT_EQ(score.wrong, 0);
}

TEST(DotColours, IdentifiesLandmarksThatAShadowsEdgeCrosses) {
  const Score score = score_of(6, 30, 4, [](ColourScene& scene, test::Random& random) {
    scene.scene.light.shadows.push_back({.direction_rad = random.uniform(0, 6.28),
                                         .offset_m = random.uniform(0.10, 0.26),
                                         .width_m = 0.3,
                                         .penumbra_m = 0.004,
                                         .remaining = 0.35});
  });
  EXPECT_GE(score.identified, 28);
  EXPECT_EQ(score.wrong, 0);
}

TEST(DotColours, IdentifiesLandmarksWithOneDotHidden) {
  const Score score = score_of(6, 30, 5, [](ColourScene& scene, test::Random& random) {
    const std::size_t dot = random.bits() % kRingDotCount;
    const test::Disc& hidden = scene.scene.sheets[0].discs[dot];
    scene.scene.sheets[0].discs.push_back({hidden.x_m, hidden.z_m + random.uniform(-0.01, 0.01), 0.022});
    scene.discs.push_back({random.uniform(0.05, 0.8), random.uniform(0.05, 0.8), random.uniform(0.05, 0.8)});
  });
  EXPECT_GE(score.identified, 26);
  EXPECT_EQ(score.wrong, 0);
}

TEST(DotColours, NamesNobodyWhereItCannotTell) {
  // Dots of 1.8 px are below what the detector is asked for; whatever is read must not be wrong.
  const Score score = score_of(1.8, 30, 6, [](auto&, auto&) {});
  EXPECT_EQ(score.wrong, 0);
  EXPECT_LT(score.identified, score.views);
}

TEST(DotColours, NamesNobodyOverExposed) {
  const Score score = score_of(
      6, 40, 7, [](ColourScene& scene, test::Random& random) { scene.scene.light.level = random.uniform(1, 12); });
  EXPECT_EQ(score.wrong, 0);
}

TEST(DotColours, WatchesAKnownLandmarkInFourFrames) {
  const std::vector<MappedLandmark> landmarks = known_landmarks();
  const CodeReader codes(landmarks);
  for (const double dot_px : {4.0, 6.0, 12.0}) {
    const ColourScene scene = scene_of(landmarks[2].code, dot_px);
    const ColourPicture picture = test::render_colour(scene, ChromaLayout::k420, 1);
    const ColourReader reader(camera_of(scene), LandmarkGeometry{});
    const PictureNoise noise(picture.luma.view());
    double own = 1, other = 1;
    std::array<int, kRingDotCount> times_read{};
    for (std::uint64_t frame = 0; frame < 4; ++frame) {
      const DotColours colours =
          reader.watch(picture.luma.view(), picture.chroma(), pose_of(scene.scene), noise, frame);
      for (std::size_t place = 0; place < kRingDotCount; ++place)
        times_read[place] += *std::ranges::min_element(colours.log_likelihood[place]) < 0;
      own *= codes.evidence_against(2, 0, colours), other *= codes.evidence_against(3, 0, colours);
    }
    EXPECT_EQ(times_read, (std::array<int, kRingDotCount>{1, 1, 1, 1, 1, 1, 1, 1})) << dot_px;
    EXPECT_LT(own, 1e-2) << dot_px;
    EXPECT_GT(other, 1e2) << dot_px;
  }
}

TEST(DotColours, WatchesAllOfSmallDotsAtOnce) {
  const std::vector<MappedLandmark> landmarks = known_landmarks();
  const CodeReader codes(landmarks);
  const ColourScene scene = scene_of(landmarks[2].code, 2.6);
  const ColourPicture picture = test::render_colour(scene, ChromaLayout::k420, 1);
  const DotColours colours =
      ColourReader(camera_of(scene), LandmarkGeometry{})
          .watch(picture.luma.view(), picture.chroma(), pose_of(scene.scene), PictureNoise(picture.luma.view()), 3);
  EXPECT_LT(codes.evidence_against(2, 0, colours), 0.1);
  EXPECT_GT(codes.evidence_against(3, 0, colours), 1e3);
}

/// A picture that has moved by `line_px` to the right while it was exposed.
struct MovedPicture {
  MovedPicture(const ColourPicture& still, int line_px) : width_px(still.luma.view().width_px) {
    const ImageView grey = still.luma.view();
    const ChromaView of_colour = still.chroma();
    luma.resize(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(grey.height_px));
    chroma.resize(luma.size() / 2);
    const auto mean = [&](int x, int width, int steps, const auto& at) {
      double sum = 0;
      for (int i = 0; i < steps; ++i) sum += at(std::clamp(x + i - steps / 2, 0, width - 1));
      return static_cast<std::uint8_t>(std::lround(sum / steps));
    };
    for (int y = 0; y < grey.height_px; ++y)
      for (int x = 0; x < width_px; ++x)
        luma[static_cast<std::size_t>(y * width_px + x)] =
            mean(x, width_px, line_px, [&](int from) { return double{1} * grey.row(y)[from]; });
    for (int y = 0; y < of_colour.height; ++y)
      for (int x = 0; x < of_colour.width; ++x)
        for (const auto& [plane, to] : {std::pair{of_colour.cb, 0}, {of_colour.cr, 1}})
          chroma[static_cast<std::size_t>(y * width_px + 2 * x + to)] = mean(
              x, of_colour.width, line_px / 2,
              [&](int from) { return double{1} * plane[y * of_colour.stride_bytes + from * of_colour.step_bytes]; });
  }
  ImageView view() const { return {luma.data(), width_px, static_cast<int>(luma.size()) / width_px, width_px}; }
  ChromaView colours() const {
    return {chroma.data(), chroma.data() + 1, width_px / 2, static_cast<int>(luma.size()) / width_px / 2, 2, width_px};
  }
  int width_px;
  std::vector<std::uint8_t> luma, chroma;
};

TEST(DotColours, AreReadAlongTheLinesThatMotionDraws) {
  const std::vector<MappedLandmark> landmarks = known_landmarks();
  const CodeReader codes(landmarks);
  constexpr int kLine_px = 10;
  int named = 0, named_as_if_it_stood = 0, wrong = 0, shown = 0;
  for (std::size_t i = 1; i < landmarks.size(); ++i)
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const ColourScene scene = scene_of(landmarks[i].code, 3.0);
      const MovedPicture picture(test::render_colour(scene, ChromaLayout::k420, seed), kLine_px);
      const ColourReader reader(camera_of(scene), LandmarkGeometry{});
      const auto read = [&](const PictureMotion& motion) {
        return codes.decode(
            reader.read(picture.view(), picture.colours(), pose_of(scene.scene), PictureNoise(picture.view()), motion));
      };
      const CodeReading along = read({.line_px = {kLine_px, 0}}), as_if_it_stood = read({});
      ++shown;
      const auto is_named = [&](const CodeReading& reading) { return reading.best && reading.odds_of_others < 0.01; };
      named += is_named(along) && along.best->landmark == i && along.best->turn == 0;
      wrong += is_named(along) && !(along.best->landmark == i && along.best->turn == 0);
      named_as_if_it_stood += is_named(as_if_it_stood) && as_if_it_stood.best->landmark == i;
    }
  EXPECT_GE(named, 0.9 * shown);
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(named_as_if_it_stood, 0.5 * shown) << "else lines need no reading of their own";
}

TEST(DotColours, KnowsNothingOfAGreyPicture) {
  const ColourScene scene = scene_of("KRGBKKRB", 8);
  ColourPicture picture = test::render_colour(scene, ChromaLayout::k420, 1);
  CameraModel camera;
  const DotColours colours =
      ColourReader(camera, LandmarkGeometry{})
          .read(picture.luma.view(), {}, pose_of(scene.scene), PictureNoise(picture.luma.view()));
  EXPECT_FALSE(colours.has_colour);
  EXPECT_EQ(letters_of(colours), "????????");
}

TEST(DotColours, KnowsNothingOfALandmarkOutsideOfThePicture) {
  const ColourScene scene = scene_of("KRGBKKRB", 8);
  const ColourPicture picture = test::render_colour(scene, ChromaLayout::k420, 1);
  const ColourReader reader(CameraModel{}, LandmarkGeometry{});
  CameraFromLandmark T = pose_of(scene.scene);
  for (const double aside_m : {-20.0, 20.0}) {
    T.translation_m.x() = aside_m;
    EXPECT_FALSE(reader.read(picture.luma.view(), picture.chroma(), T, PictureNoise(picture.luma.view())).has_colour);
  }
  T.translation_m = {0, 0, -1};
  EXPECT_FALSE(reader.read(picture.luma.view(), picture.chroma(), T, PictureNoise(picture.luma.view())).has_colour);
}

TEST(DotColours, ReadsWithoutTheHeap) {
  for (const double dot_px : {2.5, 8.0}) {
    const ColourScene scene = scene_of("KRGBKKRB", dot_px);
    const ColourPicture picture = test::render_colour(scene, ChromaLayout::k420, 1);
    const PictureNoise noise(picture.luma.view());
    const ColourReader reader(camera_of(scene), LandmarkGeometry{});
    const test::AllocationGuard guard;
    const DotColours colours = reader.read(picture.luma.view(), picture.chroma(), pose_of(scene.scene), noise);
    EXPECT_EQ(guard.allocations(), 0U) << dot_px;
    EXPECT_TRUE(colours.has_colour) << dot_px;
  }
}

}  // namespace
}  // namespace ninedot
