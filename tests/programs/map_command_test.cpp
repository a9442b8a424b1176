// `ninedot map` as it is typed, on pictures of three sheets on a wall, with exact truth.
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "base/units.h"
#include "drivers/picture/picture_file.h"
#include "geometry/landmark.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/commands/commands.h"
#include "tests/programs/typed_command.h"
#include "tests/support/random.h"
#include "world/landmark_map.h"
#include "world/sighting_fit.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth_px = 640, kHeight_px = 480, kSamples = 4;
constexpr double kFocal_px = 600, kPaper_m = 0.105;
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
Colour shown(const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
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

void write_picture(const fs::path& path, const WorldFromCamera& camera, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<std::uint8_t> pixels;
  for (int v = 0; v < kHeight_px; ++v)
    for (int u = 0; u < kWidth_px; ++u) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int sample = 0; sample < kSamples * kSamples; ++sample) {
        const double x = u + (sample % kSamples + 0.5) / kSamples - 0.5 - 319.5;
        const double y = v + (sample / kSamples + 0.5) / kSamples - 0.5 - 239.5;
        const Colour colour = shown(camera.translation_m, camera.rotation * Eigen::Vector3d(x, y, kFocal_px));
        sum += Eigen::Map<const Eigen::Vector3d>(colour.data());
      }
      const double noise = 1.5 * random.normal();
      for (const double part : sum)
        pixels.push_back(static_cast<std::uint8_t>(
            std::lround(std::fmin(255, std::fmax(0, 255 * part / (kSamples * kSamples) + noise)))));
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
    std::ofstream times(folder_ / "wall" / "frames.csv");
    times << "frame,timestamp_ns,pan_deg,tilt_deg\n";
    for (std::size_t i = 0; i < pictures; ++i) {
      const double s = static_cast<double>(i) / 5;
      const WorldFromCamera camera = looking({1.2 - 1.4 * s, 1.5 + 0.2 * s, 1.2 + 0.3 * s}, {0.6, 0, 1.4});
      char name[16];
      std::snprintf(name, sizeof name, "%06zu.png", i);
      write_picture(folder_ / "wall" / "frames" / name, camera, i);
      times << i << ',' << i * 200000000 << ",0,0\n";
    }
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

  const fs::path folder_;
};

TEST_F(MapCommandLine, PlacesSheetsThatPicturesShowTogether) {
  record(6);
  const test::TypedOutcome outcome = type({"--origin", "1", "--plan", path("plan.svg")});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_NE(outcome.said.find("3 of 3 landmarks placed"), std::string::npos) << outcome.said;
  std::ofstream(folder_ / "with_map.toml") << "map = \"map.toml\"\n";
  const LandmarkMap map = landmark_map(read_config(path("with_map.toml")));
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

}  // namespace
}  // namespace ninedot
