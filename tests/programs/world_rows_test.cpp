// What `replay --out-track` writes of the landmarks in view where no place in the world is certain.
#include "programs/commands/world_rows.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace ninedot {
namespace {

namespace fs = std::filesystem;

TEST(WorldRows, NamesWhatWasRejectedThoughNoLandmarkGivesAPlace) {
  std::string folder = (fs::temp_directory_path() / "ninedot-test-XXXXXX").string();
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  WorldRows rows(folder + "/track.csv", WorldRows::Kind::kTrack, {});
  Fix fix;
  fix.track = TrackedPose{};
  rows.add({}, fix);
  ASSERT_TRUE(fix.rejected.try_push_back(4) && fix.rejected.try_push_back(11));
  rows.add({}, fix);
  rows.file()->finish();
  std::ifstream stream(folder + "/track.csv");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_NE(text.find(",0.000000,0,,0.000,0.000,0.000\n"), std::string::npos) << text;
  EXPECT_NE(text.find(",0.000000,0,4 11,0.000,0.000,0.000\n"), std::string::npos) << text;
  fs::remove_all(folder);
}

}  // namespace
}  // namespace ninedot
