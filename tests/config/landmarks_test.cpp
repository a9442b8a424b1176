// The [[landmarks]] of a configuration, or of a map beside it, and what is made of them.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "config_text.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

using test::error_of;
using test::parse;

/// A configuration beside a map, read as the programs do. \return  every problem's line, the folder left out
std::vector<std::string> errors_with_map(const std::string& text, const std::string& map, Config* config = nullptr) {
  const std::string folder = testing::TempDir() + fmt::format("ninedot_map_{}/", ::getpid());
  const std::string path = folder + "ninedot_with_map.toml";
  std::filesystem::create_directory(folder);
  std::ofstream(path) << text;
  std::ofstream(folder + "hall.toml") << map;
  ConfigProblems problems;
  const Config read = read_config(path, problems);
  if (config != nullptr) *config = read;
  std::vector<std::string> lines;
  for (const ConfigProblem& problem : problems.list) {
    lines.push_back(problem_text(path, problem));
    for (std::size_t at; (at = lines.back().find(folder)) != std::string::npos;) lines.back().erase(at, folder.size());
  }
  std::filesystem::remove_all(folder);
  return lines;
}

/// Two landmarks of codes `a` and `b`, ids 3 and 8; no letters: no `code`.
std::string pair_of(const std::string& a, const std::string& b) {
  std::string text;
  for (const auto& [id, code] : {std::pair(3, a), std::pair(8, b)})
    text += fmt::format("[[landmarks]]\nid = {}\n{}", id, code.empty() ? "" : fmt::format("code = \"{}\"\n", code));
  return text;
}

TEST(ConfigLandmarks, AreRefusedWithoutAnIdentityOfTheirOwnOrACode) {
  EXPECT_EQ(error_of("[[landmarks]]\nid = 1\n[[landmarks]]\nid = 1\ncode = \"KRGBKKRB\""),
            "t.toml:4: two landmarks have the id 1");
  EXPECT_EQ(error_of("[[landmarks]]\nheading_deg = 5"), "t.toml:1: a landmark needs an 'id'");
  EXPECT_EQ(error_of("[[landmarks]]\nid = 1\ncode = \"KRGBKKRY\""),
            "t.toml:3: 'code' is 'KRGBKKRY'; write eight of K R G B for P1..P8");
}

TEST(ConfigLandmarks, AreRefusedWithACodeThatLooksTheSameAfterATurn) {
  EXPECT_EQ(error_of("[[landmarks]]\nid = 1\ncode = \"KRGBKRGB\""),
            "t.toml:3: 'code' KRGBKRGB looks the same when the sheet is turned by 4 dots; choose another");
  EXPECT_EQ(error_of("[[landmarks]]\nid = 1\ncode = \"RRRRRRRR\""),
            "t.toml:3: 'code' RRRRRRRR looks the same when the sheet is turned by 1 dot; choose another");
  EXPECT_EQ(error_of("[[landmarks]]\nid = 1\ncode = \"KRKRKRKG\""), "no error") << "two places, by 2 dots";
}

TEST(ConfigLandmarks, AreRefusedWhereTheirCodesDifferInFewerThanTwoPlacesAtSomeTurn) {
  const std::string choose = " places; choose codes that differ in 2 or more at every turn";
  EXPECT_EQ(
      error_of(pair_of("KRGBKKRB", "KRGBKKRB")),
      "t.toml:6: landmarks 3 and 8 can't be told apart: without any turn their colours differ in 0 of 8" + choose);
  EXPECT_EQ(
      error_of(pair_of("KRGBKKRB", "RGBKKRBK")),
      "t.toml:6: landmarks 3 and 8 can't be told apart: with the sheet of 8 turned clockwise by 1 dot their colours "
      "differ in 0 of 8" +
          choose);
  EXPECT_EQ(error_of(pair_of("KRGBKKRB", "RBKRGBKG")),
            "t.toml:6: landmarks 3 and 8 can't be told apart: with the sheet of 8 turned clockwise by 6 dots their "
            "colours differ in 1 of 8" +
                choose);
  EXPECT_EQ(error_of(pair_of("KRGBKKRB", "RBKRGBGG")), "no error") << "two places";
}

TEST(ConfigLandmarks, MayBeBlackAndWhiteTogetherAndBesideCodes) {
  EXPECT_EQ(error_of(pair_of("", "") + "[[landmarks]]\nid = 9\ncode = \"KKKKKKKK\"\n[[landmarks]]\nid = 1\ncode = "
                                       "\"KRGBKKRB\"\n"),
            "no error");
  const std::string almost = "can't be told apart: without any turn their colours differ in 1 of 8 places";
  EXPECT_NE(error_of(pair_of("", "KKKKKKKR")).find("t.toml:5: landmarks 3 and 8 " + almost), std::string::npos);
  EXPECT_NE(error_of(pair_of("KKKKKKKR", "")).find("t.toml:3: landmarks 8 and 3 " + almost), std::string::npos);
  EXPECT_EQ(error_of(pair_of("", "KKRKKKKR")), "no error");
}

TEST(ConfigLandmarks, NeedTheFullSolverWhereSeveralOrCodesAreToBeTold) {
  const std::string ellipse = "[pose]\nsolver = \"ellipse\"\n", one = "[[landmarks]]\nid = 1\n";
  EXPECT_EQ(error_of(ellipse + one), "no error");
  for (const std::string& room : {one + "[[landmarks]]\nid = 2\n", one + "code = \"KRGBKKRB\"\n"})
    EXPECT_NE(error_of(ellipse + room).find(":2: 'solver' is 'ellipse', which serves one"), std::string::npos)
        << error_of(ellipse + room);
}

TEST(ConfigLandmarks, AreReportedByDistanceUnlessTheSurestIsAskedFor) {
  const auto main_of = [](const std::string& text) { return localiser_options(parse(text)).main_landmark; };
  EXPECT_EQ(main_of(""), MainLandmark::kNearest);
  EXPECT_EQ(main_of("[pose]\nmain_landmark = \"surest\""), MainLandmark::kSurest);
  EXPECT_NE(error_of("[pose]\nmain_landmark = \"best\"").find(":2: 'main_landmark'"), std::string::npos)
      << error_of("[pose]\nmain_landmark = \"best\"");
}

TEST(ConfigLandmarks, AreToldOfOneClashEach) {
  std::string text;
  for (int id = 0; id < 30; ++id)
    text += fmt::format("[[landmarks]]\nid = {}\ncode = \"KRGBKKRB\"\nposition_mm = [0, 0, 0]\n", id);
  ConfigProblems problems;
  read_config_text(text, "t.toml", problems);
  EXPECT_EQ(problems.list.size(), 2 * 29U) << "a code and a place each, but the first";
}

TEST(ConfigLandmarks, AreRefusedTwoInOnePlace) {
  const auto two = [](const std::string& a, const std::string& b) {
    return error_of("[landmark]\nring_radius_mm = 80\n[[landmarks]]\nid = 1\n" + a + "\n[[landmarks]]\nid = 2\n" + b);
  };
  const std::string at_origin = "position_mm = [0, 0, 0]";
  EXPECT_EQ(
      two(at_origin, "position_mm = [120, 0, 90]"),
      "t.toml:8: landmarks 1 and 2 hang in one place: 150 mm apart and facing the same way, while a sheet is 210 mm "
      "wide; correct one of them");
  EXPECT_EQ(two(at_origin, "position_mm = [210, 0, 0]"), "no error") << "edge to edge";
  EXPECT_NE(two(at_origin, "position_mm = [209, 0, 0]"), "no error");
  EXPECT_EQ(two(at_origin, "position_mm = [0, 20, 0]\nheading_deg = 180"), "no error") << "back to back";
  EXPECT_EQ(two(at_origin, "position_mm = [105, -105, 0]\nheading_deg = 270"), "no error") << "around a corner";
  const std::string of_eight = "position_mm = [0, 0, 194.1]\norientation_wxyz = [0.92388, 0.382683, 0, 0]";
  EXPECT_EQ(two(at_origin, of_eight), "no error")
      << "neighbouring faces of an octagon, 210 mm cos 22.5 deg = 194.01 mm";
  EXPECT_NE(two(at_origin, "position_mm = [0, 0, 193.9]\norientation_wxyz = [0.92388, 0.382683, 0, 0]"), "no error");
  EXPECT_NE(two(at_origin, "position_mm = [0, 0, 150]\norientation_wxyz = [0.70711, 0, 0.70711, 0]"), "no error")
      << "turned in its own plane";
  EXPECT_EQ(two("code = \"KRGBKKRB\"", ""), "no error") << "nobody knows where they hang";
  EXPECT_EQ(two(at_origin, ""), "no error");
}

TEST(ConfigLandmarks, AreRefusedWithAPlaceSaidTwiceOrByHalves) {
  const std::string place = "[[landmarks]]\nid = 1\nposition_mm = [1, 2, 3]\n";
  EXPECT_EQ(error_of(place + "heading_deg = 90\norientation_wxyz = [1, 0, 0, 0]"),
            "t.toml:5: 'orientation_wxyz' and 'heading_deg' say the same: keep one of them");
  EXPECT_EQ(error_of(place + "orientation_wxyz = [0.5, 0, 0, 0]"),
            "t.toml:4: 'orientation_wxyz' has the length 0.5; write a quaternion of length 1");
  EXPECT_EQ(error_of(place + "orientation_wxyz = [0.71, 0, 0, 0.71]"), "no error") << "two digits will do";
  EXPECT_EQ(error_of(place + "orientation_wxyz = [1, 0, 0]"),
            "t.toml:4: 'orientation_wxyz' must be four numbers, [w, x, y, z]");
  EXPECT_EQ(error_of(place + "orientation_wxyz = [2, 0, 0, 0]"), "t.toml:4: 'orientation_wxyz' is 2; write -1 to 1");
  EXPECT_EQ(error_of(place + "sigma_position_mm = [1, -1, 0]"),
            "t.toml:4: 'sigma_position_mm' is -1; write 0 to 10000 mm");
  EXPECT_EQ(error_of(place + "sigma_rotation_deg = [1, 181, 0]"),
            "t.toml:4: 'sigma_rotation_deg' is 181; write 0 to 180 deg");
  for (const std::string key : {"heading_deg = 5", "orientation_wxyz = [1, 0, 0, 0]", "sigma_position_mm = [1, 1, 1]",
                                "sigma_rotation_deg = [1, 1, 1]", "from_pictures = true"})
    EXPECT_NE(error_of("[[landmarks]]\nid = 1\n" + key)
                  .find("t.toml:3: '" + key.substr(0, key.find(' ')) + "' without 'position_mm'"),
              std::string::npos)
        << key;
}

TEST(ConfigLandmarks, GetTheirPlacesOutOfMillimetresAndDegrees) {
  const LandmarkMap map = landmark_map(parse(R"(
[[landmarks]]
id = 4
code = "KRGBKKRB"
position_mm = [1000, -2500, 1200.0]
orientation_wxyz = [0.7071, 0.7071, 0, 0]
sigma_position_mm = [1, 2, 3]
sigma_rotation_deg = [0, 0, 180]
[[landmarks]]
id = 5
)"));
  ASSERT_EQ(map.landmarks().size(), 2U);
  const MappedLandmark& placed = map.landmarks()[0];
  EXPECT_TRUE(placed.has_place);
  EXPECT_TRUE(placed.T_world_landmark.translation_m.isApprox(Eigen::Vector3d(1, -2.5, 1.2), 1e-12));
  EXPECT_TRUE((placed.T_world_landmark.rotation * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0, 0, 1), 1e-12))
      << "a quarter turn about X, made exact";
  Eigen::Matrix<double, 6, 1> variances;
  variances << 1e-6, 4e-6, 9e-6, 0, 0, std::pow(std::numbers::pi, 2);
  EXPECT_TRUE(placed.covariance.diagonal().isApprox(variances, 1e-12)) << placed.covariance;
  EXPECT_FALSE(map.landmarks()[1].has_place);
}

TEST(ConfigLandmarks, AreAtTheWorldsOriginWhereOneIsAloneAndItsPlaceUntold) {
  const LandmarkMap map = landmark_map(parse("[[landmarks]]\nid = 7"));
  ASSERT_NE(map.find(7), nullptr);
  EXPECT_TRUE(map.find(7)->has_place);
  EXPECT_TRUE(map.find(7)->T_world_landmark.translation_m.isZero());
}

TEST(ConfigLandmarks, MayStandInAMapOfTheirOwn) {
  Config config;
  EXPECT_EQ(errors_with_map(
                "map = \"hall.toml\"\n",
                "[[landmarks]]\nid = 7\nposition_mm = [1, 2, 3]\n[[landmarks]]\nid = 8\ncode = \"KRGBKKRB\"", &config),
            std::vector<std::string>{});
  ASSERT_EQ(config.landmarks.size(), 2U);
  EXPECT_EQ(config.landmarks[0].position_mm, (std::array{1.0, 2.0, 3.0}));
  EXPECT_EQ(config.landmarks[1].code, "KRGBKKRB");
}

TEST(ConfigLandmarks, OfAMapAreRefusedWithItsFileAndLine) {
  const std::string map = "map = \"hall.toml\"\n";
  using Lines = std::vector<std::string>;
  EXPECT_EQ(errors_with_map(map, "[[landmarks]]\nid = 7\ncode = \"KRGBKKRY\"\n[[landmarks]]\nid = 7\n"),
            (Lines{"hall.toml:3: 'code' is 'KRGBKKRY'; write eight of K R G B for P1..P8",
                   "hall.toml:5: two landmarks have the id 7"}));
  EXPECT_EQ(errors_with_map(map + "[camera]\nrate_hz = 0", "map = \"other.toml\"\n[[landmarks]]\nid = 1\ncod = \"\"\n"),
            (Lines{"ninedot_with_map.toml:3: 'rate_hz' is 0; write 0.1 to 100000 Hz",
                   "hall.toml:1: 'map' does not belong here: a map holds [[landmarks]] only",
                   "hall.toml:4: unknown key 'cod' in [landmarks]; did you mean 'code'?"}));
  EXPECT_EQ(errors_with_map(map, "# nothing\n"), (Lines{"hall.toml:1: a map needs [[landmarks]]"}));
  EXPECT_EQ(errors_with_map(map, "[[landmarks]\n").size(), 1U);
  EXPECT_EQ(errors_with_map("\nmap = \"nowhere.toml\"", ""),
            (Lines{"ninedot_with_map.toml:2: nowhere.toml: cannot be opened: No such file or directory"}));
  EXPECT_EQ(errors_with_map(map + "[[landmarks]]\nid = 1\n", "[[landmarks]]\nid = 2\n"),
            (Lines{"ninedot_with_map.toml:2: [[landmarks]] and 'map' say the same: keep one of them"}));
  EXPECT_EQ(error_of("[camera]\nmap = \"a\""), "t.toml:2: unknown key 'map' in [camera]; it belongs above all tables");
}

TEST(ConfigLandmarks, CountTheMapsMistakesAsTheirs) {
  ConfigProblems problems;
  Config config = read_config_text("map = \"m\"\n[modbus]\n", "t.toml", problems);
  read_map_text("\n\n[[landmarks]]\n", "m", config, problems);
  EXPECT_TRUE(problems.is_in("landmarks"));
  EXPECT_FALSE(problems.is_in("modbus")) << "line 3 is the map's";
  EXPECT_EQ(problems.line_of("landmarks"), 1) << "of the key 'map'";
}

TEST(ConfigLandmarks, MayBeAThousand) {
  std::string text;
  int id = 0;
  std::vector<std::string> codes;
  for (unsigned number = 0; id < 1001; ++number) {
    std::string code;
    unsigned sum = 0;
    for (unsigned dot = 0; dot < 8; ++dot) code += "KRGB"[number >> (2 * dot) & 3U], sum += number >> (2 * dot) & 3U;
    if (sum % 4 != 0) continue;  // with a check letter two codes differ in two places, or not at all
    const auto is_code = [&](const std::string& other) { return code_distance(code, other).places == 0; };
    if (is_code("") || own_distance(code).places == 0 || std::ranges::any_of(codes, is_code)) continue;
    codes.push_back(code);
    text += fmt::format("[[landmarks]]\nid = {}\ncode = \"{}\"\nposition_mm = [0, 0, {}]\n", id, code, 210 * id);
    if (++id == 1000) {
      EXPECT_EQ(landmark_map(parse(text)).landmarks().size(), 1000U);
    }
  }
  EXPECT_EQ(error_of(text), "t.toml:4002: more than 1000 landmarks");
}

TEST(Outputs, AreTheCameraInTheWorldUnlessAskedOtherwise) {
  const Config config = parse("");
  EXPECT_EQ(config.outputs.pose, "camera_in_world");
  EXPECT_EQ(config.outputs.euler, "zyx");
  EXPECT_EQ(error_of("[outputs]\npose = \"robot\"\n"),
            "t.toml:2: 'pose' is 'robot'; write one of camera_in_world, camera_in_landmark, body_in_world");
  EXPECT_EQ(error_of("[outputs]\neuler = \"abb\"\n"), "t.toml:2: 'euler' is 'abb'; write one of zyx, fanuc, kuka");
}

TEST(Outputs, ABodyNeedsAWorldInWhichALandmarkHasAPlace) {
  const std::string body = "[outputs]\npose = \"body_in_world\"\n", place = "position_mm = [0, 0, 1200]\n";
  const std::string landmark = "[[landmarks]]\nid = 1\n", map = "map = \"hall.toml\"\n";
  const std::string what =
      "'pose' is 'body_in_world', and no landmark has a place in the world: write 'position_mm' in [[landmarks]], or a "
      "'map'";
  EXPECT_EQ(error_of(body), "t.toml:2: " + what);
  EXPECT_EQ(error_of(landmark + body), "t.toml:4: " + what);
  EXPECT_EQ(parse(landmark + place + body).outputs.pose, "body_in_world");
  using Lines = std::vector<std::string>;
  EXPECT_EQ(errors_with_map(map + body, landmark), (Lines{"ninedot_with_map.toml:3: " + what}));
  EXPECT_EQ(errors_with_map(map + body, landmark + place), Lines{});
}

}  // namespace
}  // namespace ninedot
