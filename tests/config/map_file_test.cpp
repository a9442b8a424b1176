#include "config/map_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include <string>
#include <vector>

#include "config/config_checks.h"
#include "programs/assembly/localiser_options.h"

namespace ninedot {
namespace {

MappedLandmark placed() {
  MappedLandmark landmark{7, "KRGBKKRB", {exp_so3({0.3, -0.2, 2.5}), {1.2345678, -20, 1.5}}};
  landmark.covariance.diagonal() << 1e-6, 4e-6, 1e-14, 1e-6, 1e-6, 1e-8;
  return landmark;
}

/// What the configuration makes of the text.
LandmarkMap read_back(const std::string& text) {
  ConfigProblems problems;
  Config config = read_config_text("map = \"m.toml\"\n", "c.toml", problems);
  read_map_text(text, "m.toml", config, problems);
  for (const ConfigProblem& problem : problems.list) ADD_FAILURE() << problem_text("c.toml", problem) << "\n" << text;
  return landmark_map(config);
}

TEST(MapFile, ComesBackAsItWas) {
  const std::vector<MappedLandmark> landmarks{{1, "", {}}, placed()};
  const std::vector<std::string> comment{"two landmarks"}, notes{"given", ""};
  const std::string text = format_map(landmarks, comment, notes);
  EXPECT_TRUE(text.starts_with("# two landmarks\n\n[[landmarks]]  # given\nid = 1\nposition_mm")) << text;
  const LandmarkMap map = read_back(text);
  ASSERT_EQ(map.landmarks().size(), 2U);
  EXPECT_TRUE(map.find(1)->covariance.isZero(0)) << "exact";
  const MappedLandmark& back = *map.find(7);
  EXPECT_EQ(back.code, "KRGBKKRB");
  EXPECT_LT((back.T_world_landmark.translation_m - placed().T_world_landmark.translation_m).norm(), 1e-6);
  EXPECT_LT((back.T_world_landmark.rotation - placed().T_world_landmark.rotation).norm(), 1e-8);
  for (const Eigen::Index i : {0, 1, 3, 4, 5})
    EXPECT_NEAR(std::sqrt(back.covariance(i, i)), std::sqrt(placed().covariance(i, i)), i < 3 ? 1.1e-7 : 2e-6) << i;
  EXPECT_GT(back.covariance(2, 2), 0) << "what is nearly exact stays uncertain";
}

TEST(MapFile, SaysNoPlaceWhereThereIsNone) {
  MappedLandmark unknown{3, "RRGKBGKB", {}};
  unknown.has_place = false;
  const std::string text = format_map(std::vector{unknown, placed()}, {}, std::vector<std::string>(2));
  EXPECT_FALSE(read_back(text).find(3)->has_place);
}

TEST(MapFile, TellsWhatFollowsFromPicturesFromWhatWasMeasured) {
  MappedLandmark found = placed();
  found.id = 8, found.code = "RRGKBGKB", found.from_pictures = true;
  found.T_world_landmark.translation_m.x() += 1;
  const LandmarkMap map = read_back(format_map(std::vector{placed(), found}, {}, std::vector<std::string>(2)));
  EXPECT_FALSE(map.find(7)->from_pictures);
  EXPECT_TRUE(map.find(8)->from_pictures);
}

}  // namespace
}  // namespace ninedot
