#include "config/config_edit.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/startup_error.h"

namespace ninedot {
namespace {

std::string refusal_of(const std::string& text, const std::vector<KeyText>& keys) {
  try {
    with_keys(text, keys, "ninedot.toml");
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    return error.what();
  }
  ADD_FAILURE() << "was not refused: " << text;
  return {};
}

TEST(ConfigEdit, SetsKeysWhereTheyStandAndTouchesNothingElse) {
  EXPECT_EQ(with_keys("# größer\n[body] # über\ncamera_mm = [1,\n  2, # zwei\n  3]  # as built\n\n"
                      "  [ pan_tilt . pan ]\nmin_deg = -16.5# left\nmax_deg=3",
                      std::vector<KeyText>{{"body", "camera_mm", "[4, 5, 6]"},
                                           {"pan_tilt.pan", "min_deg", "-20"},
                                           {"pan_tilt.pan", "max_deg", "20"}},
                      "ninedot.toml"),
            "# größer\n[body] # über\ncamera_mm = [4, 5, 6]  # as built\n\n"
            "  [ pan_tilt . pan ]\nmin_deg = -20# left\nmax_deg=20");
}

TEST(ConfigEdit, CountsCharactersAndNotBytes) {
  EXPECT_EQ(with_keys("[a]\n\"größe\" = \"ü\" # ä\n", std::vector<KeyText>{{"a", "größe", "\"öö\""}}, "x"),
            "[a]\n\"größe\" = \"öö\" # ä\n");
}

TEST(ConfigEdit, AddsAKeyAsTheFirstOfItsTableAndATableAsTheLast) {
  EXPECT_EQ(with_keys("[body]   # ours\nx = 1\n[body.y]\nz = 2",
                      std::vector<KeyText>{{"body", "a", "3"}, {"b", "c", "4"}}, "x"),
            "[body]   # ours\na = 3\nx = 1\n[body.y]\nz = 2\n\n[b]\nc = 4\n");
  EXPECT_EQ(with_keys("", std::vector<KeyText>{{"b", "c", "4"}, {"b", "d", "5"}}, "x"), "\n\n[b]\nd = 5\nc = 4\n");
  EXPECT_EQ(with_keys("[body]", std::vector<KeyText>{{"body", "a", "3"}}, "x"), "[body]\na = 3");
  EXPECT_EQ(with_keys("[pan_tilt.pan]\nx = 1\n", std::vector<KeyText>{{"pan_tilt.tilt", "x", "2"}}, "x"),
            "[pan_tilt.pan]\nx = 1\n\n[pan_tilt.tilt]\nx = 2\n");
  EXPECT_EQ(with_keys("[body]\r\nx = 1\r\n", std::vector<KeyText>{{"body", "x", "2"}}, "x"), "[body]\r\nx = 2\r\n");
}

TEST(ConfigEdit, RefusesATableOfAnotherForm) {
  const std::vector<KeyText> keys{{"pan_tilt.pan", "x", "2"}};
  const std::string said =
      "ninedot.toml: 'x' can't be set in it: give [pan_tilt.pan] a line of its own, and its keys below it";
  EXPECT_EQ(refusal_of("[pan_tilt]\npan = {y = 1}\n", keys), said);
  EXPECT_EQ(refusal_of("[pan_tilt]\npan.y = 1\n", keys), said);
  EXPECT_NE(refusal_of("[pan_tilt]\npan = 3\n", keys).find("ninedot.toml:"), std::string::npos);
  EXPECT_NE(refusal_of("pan_tilt = {pan = {}}\n", keys).find("ninedot.toml"), std::string::npos);
  EXPECT_NE(refusal_of("[[pan_tilt]]\n", keys).find("ninedot.toml"), std::string::npos);
  EXPECT_EQ(refusal_of("[pan_tilt\n", keys).substr(0, 15), "ninedot.toml:1:");
}

TEST(ConfigEdit, FindsWhatStandsInItsWayTheSameInOtherForms) {
  EXPECT_EQ(with_keys("[pan_tilt]\npan = {x = 1}\n", std::vector<KeyText>{{"pan_tilt.pan", "x", "2"}}, "x"),
            "[pan_tilt]\npan = {x = 2}\n");
  EXPECT_EQ(with_keys("pan_tilt.pan.x = 1\n", std::vector<KeyText>{{"pan_tilt.pan", "x", "2"}}, "x"),
            "pan_tilt.pan.x = 2\n");
}

TEST(ConfigEdit, ReadsTheKeysOfTables) {
  const std::vector<KeyText> keys = keys_of(
      "top = 1\n[body]\na = [1, # one\n 2]  # behind\nb = {c = 1}\n[pan_tilt.pan]\nd = \"é\" # x\n[[landmarks]]\nid = "
      "1\n",
      "x");
  ASSERT_EQ(keys.size(), 3U);
  EXPECT_EQ(keys[0].table + " " + keys[0].key + " " + keys[0].value, "body a [1, # one\n 2]");
  EXPECT_EQ(keys[1].value, "{c = 1}");
  EXPECT_EQ(keys[2].table + " " + keys[2].value, "pan_tilt.pan \"é\"");
  EXPECT_THROW(keys_of("a = = 2", "x"), StartupError);
}

std::string refusal_of_map(const std::string& text) {
  try {
    with_map_named(text, "\"map.toml\"", "ninedot.toml");
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    return error.what();
  }
  ADD_FAILURE() << "was not refused: " << text;
  return {};
}

std::string with_map(const std::string& text) { return with_map_named(text, "\"map.toml\"", "x"); }

TEST(ConfigEdit, PutsAMapInThePlaceOfTheLandmarksAndTouchesNothingElse) {
  EXPECT_EQ(with_map("# a größer hall\n[camera]\nwidth_px = 640\n\n# by the door\n[[landmarks]] # one\nid = 1 # ö\n"
                     "# between\nposition_mm = [1,\n  2, 3] # measured\n\n[[landmarks]]\nid = 2\n# the "
                     "head\n[pan_tilt]\ndriver = \"none\"\n[[landmarks]]\nid = 3"),
            "map = \"map.toml\"\n# a größer hall\n[camera]\nwidth_px = 640\n\n# by the door\n# the "
            "head\n[pan_tilt]\ndriver = \"none\"\n");
  EXPECT_EQ(with_map("map = \"\" # none yet\n[camera]\n"), "map = \"map.toml\" # none yet\n[camera]\n");
  EXPECT_EQ(with_map(""), "map = \"map.toml\"\n");
  EXPECT_EQ(with_map("[[landmarks]]\r\nid = 1\r\n[web]\r\n"), "map = \"map.toml\"\n[web]\r\n");
  EXPECT_EQ(with_map("[web]\nkey = '''\n[[landmarks]]\nid = 1\n'''\n"),
            "map = \"map.toml\"\n[web]\nkey = '''\n[[landmarks]]\nid = 1\n'''\n");
}

TEST(ConfigEdit, RefusesLandmarksThatCanNotBeTakenOut) {
  const std::string said =
      "ninedot.toml: the landmarks can't be taken out of it, and a map takes their place: give each a [[landmarks]] of "
      "its own, and its keys below it";
  EXPECT_EQ(refusal_of_map("landmarks = [{id = 1}, {id = 2}]\n"), said);
  EXPECT_EQ(refusal_of_map("landmarks = [1, 2]\n"), said);
  EXPECT_EQ(refusal_of_map("[[landmarks]]\nid = 1\n[landmarks.more]\na = 1\n"), said) << "it would leave half of it";
  EXPECT_EQ(refusal_of_map("[[landmarks\n").substr(0, 15), "ninedot.toml:1:");
}

TEST(ConfigEdit, IsNotExhaustedByTextsThatAreMadeTo) {
  std::string dots = "[a]\na";
  for (int i = 0; i < 200'000; ++i) dots += ".a";
  EXPECT_THROW(keys_of(dots + " = 1\n", "x"), StartupError);
}

}  // namespace
}  // namespace ninedot
