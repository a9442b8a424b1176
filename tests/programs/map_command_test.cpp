// `ninedot map` as it is typed, on pictures of three sheets on a wall, with exact truth.
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "base/units.h"
#include "drivers/picture/picture_file.h"
#include "geometry/landmark.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/commands/collect_sightings.h"
#include "programs/commands/commands.h"
#include "tests/programs/typed_command.h"
#include "tests/support/random.h"
#include "world/landmark_codes.h"
#include "world/landmark_map.h"
#include "world/sighting_fit.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth_px = 640, kHeight_px = 480, kSamples = 4;
constexpr double kFocal_px = 600, kPaper_m = 0.105;
constexpr std::size_t kSwingPeriod_ns = 30'000'000;
using Colour = std::array<double, 3>;

struct Sheet {
  int id;
  const char* code;
  WorldFromLandmark place;
};

/// The wall is the plane Y = 0; the third sheet hangs on a wall of its own at its end.
const std::vector<Sheet>& sheets() {
  static const std::vector<Sheet> all{{1, "KRGBKKRB", place_upright({0, 0, 1.4}, 0)},
                                      {2, "RRGKBGKB", place_upright({0.7, 0, 1.5}, 0.02)},
                                      {3, "KKGRRBGB", place_upright({1.3, 0.3, 1.3}, 0.7)}};
  return all;
}

Colour ink(char letter) {
  if (letter == 'R') return {0.68, 0.24, 0.26};
  if (letter == 'G') return {0.27, 0.58, 0.35};
  return letter == 'B' ? Colour{0.24, 0.35, 0.65} : Colour{0.20, 0.20, 0.20};
}

/// What a ray shows: dots, paper, or the grey wall behind.
Colour shown(const Eigen::Vector3d& from, const Eigen::Vector3d& along, bool has_poster) {
  for (const Sheet& sheet : sheets()) {
    const Eigen::Vector3d p = sheet.place.rotation.transpose() * (from - sheet.place.translation_m);
    const Eigen::Vector3d d = sheet.place.rotation.transpose() * along;
    const double t = -p.y() / d.y();
    const Eigen::Vector2d at(p.x() + t * d.x(), p.z() + t * d.z());
    if (t <= 0 || at.cwiseAbs().maxCoeff() > kPaper_m) continue;
    const LandmarkGeometry geometry{};
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      if ((at - geometry.centre_m(dot)).norm() < geometry.radius_m(dot))
        return ink(dot == kCentreDot ? 'K' : sheet.code[dot]);
    return {0.92, 0.92, 0.92};
  }
  // A dark poster, to the viewer's left of the upper half of the first sheet.
  const double t = -from.y() / along.y(), x_m = from.x() + t * along.x(), z_m = from.z() + t * along.z();
  if (has_poster && std::abs(x_m - 0.255) < 0.15 && std::abs(z_m - 1.55) < 0.15) return {0.05, 0.05, 0.05};
  return {0.6, 0.6, 0.6};
}

/// From `position` towards `target`, upright.
WorldFromCamera looking(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - position).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << right, forward.cross(right), forward;
  return {R, position};
}

struct Look {
  double seen_px = 1;  ///< each pixel sees a square of that side
  bool has_poster = false;
};

/// \param camera_at  where the camera is while a row is exposed
void write_picture(const fs::path& path, const std::function<WorldFromCamera(int row)>& camera_at, std::uint64_t seed,
                   const Look& look) {
  test::Random random(seed);
  std::vector<std::uint8_t> pixels;
  for (int v = 0; v < kHeight_px; ++v) {
    const WorldFromCamera camera = camera_at(v);
    for (int u = 0; u < kWidth_px; ++u) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int sample = 0; sample < kSamples * kSamples; ++sample) {
        const double x = u + look.seen_px * ((sample % kSamples + 0.5) / kSamples - 0.5) - 319.5;
        const double y = v + look.seen_px * ((sample / kSamples + 0.5) / kSamples - 0.5) - 239.5;
        const Colour colour =
            shown(camera.translation_m, camera.rotation * Eigen::Vector3d(x, y, kFocal_px), look.has_poster);
        sum += Eigen::Map<const Eigen::Vector3d>(colour.data());
      }
      const double noise = 1.5 * random.normal();
      for (const double part : sum)
        pixels.push_back(static_cast<std::uint8_t>(
            std::lround(std::fmin(255, std::fmax(0, 255 * part / (kSamples * kSamples) + noise)))));
    }
  }
  ASSERT_TRUE(write_png_rgb(path.string(), pixels, {kWidth_px, kHeight_px}));
}

class MapCommandLine : public testing::Test {
 protected:
  MapCommandLine() : folder_(fs::temp_directory_path() / ("ninedot_map_command_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_ / "wall" / "frames");
    write_config("");
    std::ofstream(folder_ / "wall" / "camera.yaml") << "image_width: 640\nimage_height: 480\ncamera_name: "
                                                       "test\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [600, 0, "
                                                       "319.5, 0, 600, 239.5, 0, 0, 1]\ndistortion_model: "
                                                       "plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  "
                                                       "data: [0, 0, 0, 0, 0]\n";
  }
  ~MapCommandLine() override { fs::remove_all(folder_); }

  void write_config(const std::string& more) {
    std::ofstream file(folder_ / "ninedot.toml");
    for (const Sheet& sheet : sheets())
      file << "[[landmarks]]\nid = " << sheet.id << "\ncode = \"" << sheet.code << "\"\n";
    file << more;
  }

  void record(std::size_t pictures) {
    write_recording(pictures, 200'000'000, [](std::size_t picture, int /*row*/) {
      const double s = static_cast<double>(picture) / 5;
      return looking({1.2 - 1.4 * s, 1.5 + 0.2 * s, 1.2 + 0.3 * s}, {0.6, 0, 1.4});
    });
  }
  /// Rows one after the other by a camera that swings, the sheets in the upper third of its pictures.
  void record_swinging(std::size_t pictures) { write_recording(pictures, kSwingPeriod_ns, swinging); }
  static WorldFromCamera swinging(std::size_t picture, int row) {
    const double time_s = 1e-9 * static_cast<double>(picture * kSwingPeriod_ns) + 33e-6 * (row - 239.5);
    return looking({0.6, 2.6, 1.3}, {0.6 + 0.3 * std::sin(2 * std::numbers::pi * time_s / 0.8), 0, 0.6});
  }
  void write_recording(std::size_t pictures, std::size_t period_ns,
                       const std::function<WorldFromCamera(std::size_t picture, int row)>& camera_at,
                       const Look& look = {}) {
    std::ofstream times(folder_ / "wall" / "frames.csv");
    times << "frame,timestamp_ns,pan_deg,tilt_deg\n";
    for (std::size_t i = 0; i < pictures; ++i) {
      char name[16];
      std::snprintf(name, sizeof name, "%06zu.png", i);
      write_picture(
          folder_ / "wall" / "frames" / name, [&](int row) { return camera_at(i, row); }, i, look);
      times << i << ',' << i * period_ns << ",0,0\n";
    }
  }

  /// The same pictures, each taken a minute after the one before.
  void stand_still() {
    std::ofstream times(folder_ / "wall" / "frames.csv");
    times << "frame,timestamp_ns,pan_deg,tilt_deg\n";
    for (std::uint64_t i = 0; i < 6; ++i) times << i << ',' << i * 60'000'000'000 << ",0,0\n";
  }

  /// `ninedot map wall --config ninedot.toml --out map.toml WORDS`
  test::TypedOutcome type(std::vector<std::string> words) {
    words.insert(words.begin(), {"map", path("wall"), "--config", path("ninedot.toml"), "--out", path("map.toml")});
    return test::type_command(add_map_command, std::move(words));
  }
  void fails(ExitStatus status, const std::vector<std::string>& words, const std::string& what) {
    test::expect_refusal(type(words), status, what);
    EXPECT_FALSE(fs::exists(folder_ / "map.toml"));
  }

  std::string path(const char* name) const { return (folder_ / name).string(); }

  std::string text_of(const char* name) const {
    std::ifstream stream(folder_ / name);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  /// As `map = "map.toml"` gives it.
  LandmarkMap made() {
    std::ofstream(folder_ / "with_map.toml") << "map = \"map.toml\"\n";
    return landmark_map(read_config(path("with_map.toml")));
  }
  /// How far from where it truly hangs, relative to the first one. [m]
  static double error_m(const LandmarkMap& map, std::size_t sheet) {
    const WorldFromLandmark& origin = map.find(1)->T_world_landmark;
    const WorldFromLandmark& truth = sheets()[0].place;
    const MappedLandmark& placed = *map.find(static_cast<std::uint16_t>(sheets()[sheet].id));
    return (origin.inverse() * placed.T_world_landmark.translation_m -
            truth.inverse() * sheets()[sheet].place.translation_m)
        .norm();
  }

  const fs::path folder_;
};

TEST_F(MapCommandLine, PlacesSheetsThatPicturesShowTogether) {
  record(6);
  fails(ExitStatus::kWorkFailed, {"--origin", "1", "--plan", "/dev/full"}, "No space left");
  const test::TypedOutcome outcome = type({"--origin", "1", "--plan", path("plan.svg")});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_NE(outcome.said.find("3 of 3 landmarks placed"), std::string::npos) << outcome.said;
  const LandmarkMap map = made();
  const WorldFromLandmark origin = sheets()[0].place;
  ASSERT_EQ(map.landmarks().size(), 3U);
  for (const Sheet& sheet : sheets()) {
    const MappedLandmark& placed = *map.find(static_cast<std::uint16_t>(sheet.id));
    const WorldFromLandmark expected = {origin.rotation.transpose() * sheet.place.rotation,
                                        origin.inverse() * sheet.place.translation_m};
    EXPECT_EQ(placed.code, sheet.code);
    const double error_m = (placed.T_world_landmark.translation_m - expected.translation_m).norm();
    EXPECT_LT(error_m, 0.004) << sheet.id;
    EXPECT_LE(error_m, 5 * std::sqrt(placed.covariance.topLeftCorner<3, 3>().trace())) << sheet.id;
    EXPECT_LT(log_so3(placed.T_world_landmark.rotation.transpose() * expected.rotation).norm(), 0.5 * kRadPerDeg);
  }
  EXPECT_TRUE(fs::exists(folder_ / "plan.svg"));
}

/// Of a shutter that nobody has told of the map knows nothing: it is made of the same pictures.
TEST_F(MapCommandLine, SaysThatACameraWhichMovesMustTellItsShutter) {
  record(6);
  const char* const kNote = "camera.row_time_us is not told";
  EXPECT_NE(type({"--origin", "1"}).said.find(kNote), std::string::npos);
  write_config("[camera]\nrow_time_us = 0\n");
  EXPECT_EQ(type({"--origin", "1"}).said.find(kNote), std::string::npos);
  write_config("");
  stand_still();
  EXPECT_EQ(type({"--origin", "1"}).said.find(kNote), std::string::npos) << "pictures at rest";
}

/// A map in which the turns of a rolling shutter's rows count for nothing is bent by them, and certain of itself.
TEST_F(MapCommandLine, TakesASightingForAsUncertainAsItsRows) {
  record(4);
  const auto largest_turn_rad = [&](const char* shutter) {
    write_config(shutter);
    const CameraModel camera = read_camera_file(path("wall/camera.yaml"));
    double largest = 0;
    for (const RecordedSightings& frame :
         collect_sightings(path("wall"), 0, read_config(path("ninedot.toml")), camera, {}))
      for (const LandmarkSighting& seen : frame.list) largest = std::max(largest, seen.turn_sigma_rad);
    return largest;
  };
  EXPECT_GT(largest_turn_rad("[camera]\nrow_time_us = 30\n"), 1e-5);
  EXPECT_EQ(largest_turn_rad("[camera]\nrow_time_us = 0\n"), 0);
}

TEST_F(MapCommandLine, KnowsByTheNextPictureHowTheCameraTurned) {
  record_swinging(8);
  write_config("[camera]\nrow_time_us = 33\n");
  const CameraModel camera = read_camera_file(path("wall/camera.yaml"));
  double squares_px2 = 0, count = 0;
  for (const RecordedSightings& frame :
       collect_sightings(path("wall"), 0, read_config(path("ninedot.toml")), camera, {}))
    for (const LandmarkSighting& seen : frame.list) {
      const WorldFromCamera at = swinging(frame.frame, 240);
      const auto& sheet = *std::ranges::find(sheets(), int{seen.id}, &Sheet::id);
      const Eigen::Vector3d p = at.rotation.transpose() * (sheet.place.translation_m - at.translation_m);
      squares_px2 += (seen.T_camera_landmark.translation_m.hnormalized() - p.hnormalized()).squaredNorm() / 2 *
                     kFocal_px * kFocal_px;
      ++count;
    }
  EXPECT_GE(count, 20);
  EXPECT_LT(std::sqrt(squares_px2 / count), 0.05) << "px";
}

/// Of a single picture's dot it is half of its noise; a map is made of a hundred.
TEST_F(MapCommandLine, RegardsWhatHangsBesideASheet) {
  const auto camera_in = [](std::size_t picture, int /*row*/) {
    const double s = 0.4 * static_cast<double>(picture);
    return looking({0.4 + 0.3 * std::sin(5 * s), 4.9 - 0.02 * s, 1.3 + 0.1 * std::cos(7 * s)}, {0.35, 0, 1.4});
  };
  write_recording(12, 1'000'000'000, camera_in, {2.4, true});
  write_config("[camera]\nrow_time_us = 0\n");
  const CameraModel camera = read_camera_file(path("wall/camera.yaml"));
  constexpr std::size_t kLeftDot = 2;
  const Eigen::Vector2d on_sheet_m = LandmarkGeometry{}.centre_m(kLeftDot);
  Eigen::Vector2d sum_px = Eigen::Vector2d::Zero();
  int count = 0;
  for (const RecordedSightings& frame :
       collect_sightings(path("wall"), 0, read_config(path("ninedot.toml")), camera, {}))
    for (const LandmarkSighting& seen : frame.list) {
      if (seen.id != 1 || seen.dots[kLeftDot].information.isZero(0)) continue;
      const WorldFromCamera at = camera_in(frame.frame, 0);
      const Eigen::Vector3d p_m =
          at.inverse() * (sheets()[0].place * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y()));
      sum_px += kFocal_px * (seen.dots[kLeftDot].ray - p_m.hnormalized());
      ++count;
    }
  ASSERT_GE(count, 8);
  EXPECT_LT(std::abs(sum_px.y() / count), 0.02);
}

TEST_F(MapCommandLine, RefusesWhatItCanNotStartFrom) {
  record(1);
  fails(ExitStatus::kWrongUsage, {"--origin", "9"}, "--origin 9: ");
  fails(ExitStatus::kWrongUsage, {"--origin", "1", "--origin", "2"},
        "--origin 2: a further origin needs its position_mm");
  fails(ExitStatus::kWorkFailed, {"--origin", "1"}, "no landmark could be placed");
  std::ofstream(folder_ / "other.yaml") << "image_width: 320\nimage_height: 240\ncamera_name: test\ncamera_matrix:\n  "
                                           "rows: 3\n  cols: 3\n  data: [300, 0, "
                                           "160, 0, 300, 120, 0, 0, 1]\ndistortion_model: "
                                           "plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: "
                                           "[0, 0, 0, 0, 0]\n";
  fails(ExitStatus::kWrongUsage, {"--origin", "1", "--camera", path("other.yaml")}, "the calibration is for 320x240");
  fs::create_directories(folder_ / "empty" / "frames");
  fails(ExitStatus::kWrongUsage, {path("empty"), "--origin", "1"}, "empty");
  fails(ExitStatus::kWrongUsage, {path("nowhere"), "--origin", "1"}, "nowhere");
  fails(ExitStatus::kWorkFailed, {"--origin", "1", "--plan", path("nowhere/plan.svg")}, "nowhere/plan.svg");
  std::ofstream(folder_ / "ninedot.toml") << "[[landmarks]]\nid = 1\ncode = \"KRGBKKRB\"\n";
  fails(ExitStatus::kWrongUsage, {"--origin", "1"}, "a map needs two [[landmarks]]");
}

TEST_F(MapCommandLine, SaysInOneLineWhyNothingCameOfIt) {
  record(2);
  fails(ExitStatus::kWrongUsage, {"--origin", "measured"}, "has no landmark with a measured place");
  fails(ExitStatus::kWrongUsage, {"--origin", "map"}, "has no landmark with a place");
  fails(ExitStatus::kWrongUsage, {"--origin", "door"}, "give the id of a landmark");
  fails(ExitStatus::kWrongUsage, {"--origin", "1", "--origin", "map"}, "give the id of a landmark");
  write_config("[[landmarks]]\nid = 77\ncode = \"BGGGKRGG\"\n");
  fails(ExitStatus::kWorkFailed, {"--origin", "77"}, "together are seen: 1, 2, 3");
  std::ofstream(folder_ / "ninedot.toml")
      << "[[landmarks]]\nid = 7\ncode = \"BGRBKKBK\"\n[[landmarks]]\nid = 8\ncode = \"BGGGKRGG\"\n";
  fails(ExitStatus::kWorkFailed, {"--origin", "7"}, "no picture shows one of the configuration's");
  std::ofstream(folder_ / "ninedot.toml")
      << "[[landmarks]]\nid = 1\ncode = \"KRGBKKRB\"\n[[landmarks]]\nid = 8\ncode = \"BGGGKRGG\"\n";
  fails(ExitStatus::kWorkFailed, {"--origin", "1"}, "seen one at a time: 1");
}

TEST_F(MapCommandLine, KeepsWhatWasMeasuredAndFindsTheRestAnew) {
  record(6);
  std::ofstream(folder_ / "ninedot.toml") << R"([[landmarks]]
id = 1
code = "KRGBKKRB"
position_mm = [1000, 2000, 1400]
heading_deg = 90
[[landmarks]]
id = 2
code = "RRGKBGKB"
position_mm = [5000, 5000, 5000]
sigma_position_mm = [1, 1, 1]
sigma_rotation_deg = [0.1, 0.1, 0.1]
from_pictures = true
[[landmarks]]
id = 3
code = "KKGRRBGB"
[[landmarks]]
id = 9
code = "BGGGKRGG"
)";
  const test::TypedOutcome outcome = type({"--origin", "measured"});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_NE(outcome.said.find("landmark 9 is not placed: no picture shows it\n"), std::string::npos) << outcome.said;
  EXPECT_NE(outcome.said.find("3 of 4 landmarks placed"), std::string::npos) << outcome.said;
  const LandmarkMap map = made();
  EXPECT_EQ(map.landmarks().size(), 4U) << "none is lost";
  EXPECT_FALSE(map.find(9)->has_place);
  EXPECT_FALSE(map.find(1)->from_pictures);
  EXPECT_LT((map.find(1)->T_world_landmark.translation_m - Eigen::Vector3d(1, 2, 1.4)).norm(), 1e-9);
  for (const std::size_t sheet : {1U, 2U}) {
    EXPECT_TRUE(map.find(static_cast<std::uint16_t>(sheets()[sheet].id))->from_pictures);
    EXPECT_LT(error_m(map, sheet), 0.004);
  }
  // Again with that very map: what follows from pictures is found anew, and counts once.
  std::ofstream(folder_ / "ninedot.toml") << "map = \"first.toml\"\n";
  fs::copy_file(folder_ / "map.toml", folder_ / "first.toml");
  ASSERT_EQ(type({"--origin", "measured"}).status, ExitStatus::kSuccess);
  const double sigma_m = std::sqrt(map.find(2)->covariance(0, 0));
  EXPECT_NEAR(std::sqrt(made().find(2)->covariance(0, 0)), sigma_m, 0.1 * sigma_m);
}

TEST_F(MapCommandLine, JoinsWhatIsNewToTheMapThatThereIs) {
  record(6);
  ASSERT_EQ(type({"--origin", "1"}).status, ExitStatus::kSuccess);
  const LandmarkMap before = made();
  // Of the third one nobody knows any more where it hangs.
  const std::string first = text_of("map.toml");
  std::ofstream(folder_ / "first.toml") << first.substr(0, first.find("\n[[landmarks]]", first.find("id = 2")))
                                        << "\n[[landmarks]]\nid = 3\ncode = \"KKGRRBGB\"\n";
  std::ofstream(folder_ / "ninedot.toml") << "map = \"first.toml\"\n";
  const test::TypedOutcome outcome = type({"--origin", "map"});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  const LandmarkMap map = made();
  EXPECT_LT(error_m(map, 2), 0.004);
  EXPECT_TRUE(map.find(2)->from_pictures);
  EXPECT_LT(map.find(2)->covariance(0, 0), 0.7 * before.find(2)->covariance(0, 0)) << "its place counted as well";
}

TEST_F(MapCommandLine, NamesSheetsThatTheConfigurationDoesNotHave) {
  record(6);
  std::ofstream(folder_ / "ninedot.toml") << "[[landmarks]]\nid = 1\ncode = \"KRGBKKRB\"\n";
  const test::TypedOutcome outcome = type({"--origin", "1", "--new"});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_NE(outcome.said.find("3 of 3 landmarks placed"), std::string::npos) << outcome.said;
  const LandmarkMap map = made();
  ASSERT_EQ(map.landmarks().size(), 3U) << text_of("map.toml");
  for (const std::size_t sheet : {1U, 2U}) EXPECT_LT(error_m(map, sheet), 0.004);
  EXPECT_EQ(map.find(3)->code, "KKGRRBGB");
  // Nothing at all is configured.
  std::ofstream(folder_ / "ninedot.toml") << "";
  ASSERT_EQ(type({"--origin", "2", "--new"}).status, ExitStatus::kSuccess);
  EXPECT_TRUE(made().find(2)->T_world_landmark.translation_m.isZero());
}

// Without a code of its own the sheet was placed under the id of the nearest one.
TEST_F(MapCommandLine, NamesASheetWhoseIdTheConfigurationGivesToAnotherCode) {
  record(6);
  std::ofstream(folder_ / "ninedot.toml") << "[[landmarks]]\nid = 2\ncode = \"RRRRKKBB\"\n"
                                             "[[landmarks]]\nid = 161\ncode = \"KRGBKKRB\"\n";
  const test::TypedOutcome outcome = type({"--origin", "161", "--new"});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_NE(outcome.said.find("landmark 162 is the sheet of `ninedot pattern --id 2`"), std::string::npos)
      << outcome.said;
  const LandmarkMap map = made();
  ASSERT_NE(map.find(162), nullptr) << text_of("map.toml");
  EXPECT_EQ(map.find(162)->code, known_code(2));
  EXPECT_TRUE(map.find(162)->has_place);
  EXPECT_FALSE(map.find(2)->has_place);
}

TEST_F(MapCommandLine, TellsAnotherProgramHowItFares) {
  record(6);
  write_config("[camera]\nrow_time_us = 0\n");
  testing::internal::CaptureStdout();
  const test::TypedOutcome outcome = type({"--origin", "1", "--plan", path("plan.svg"), "--progress", "json"});
  const std::string news = testing::internal::GetCapturedStdout();
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_TRUE(news.starts_with(R"({"state":"reading","look":1,"recording":1,"recordings":1,"frame":1,"frames":6})"))
      << news;
  const std::string last = news.substr(news.rfind('\n', news.size() - 2) + 1);
  EXPECT_TRUE(last.starts_with(R"({"state":"done","summary":"3 of 3 landmarks placed, from )")) << last;
  EXPECT_NE(
      last.find(
          R"("placed":[{"id":1,"mm":[0.00,0.00,0.00],"q":[1.00000,0.00000,0.00000,0.00000],"sigma_mm":[0,0,0],"sigma_deg":0,"sightings":)"),
      std::string::npos)
      << last;
  EXPECT_NE(last.find(R"("how":"found","new":false}],"lines":[],)"), std::string::npos) << last;
  testing::internal::CaptureStdout();
  EXPECT_EQ(type({"--origin", "9", "--progress", "json"}).status, ExitStatus::kWrongUsage);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), R"({"state":"failed","why":"--origin 9: )" + path("ninedot.toml") +
                                                        " has no such landmark; it has 1, 2, 3\"}\n");
}

}  // namespace
}  // namespace ninedot
