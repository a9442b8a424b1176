#include "programs/commands/named_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "base/startup_error.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

class ANamedFile : public testing::Test {
 protected:
  ANamedFile() {
    std::string pattern = (fs::temp_directory_path() / "ninedot-test-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) std::abort();
    folder_ = pattern;
    config_ = (folder_ / "ninedot.toml").string();
    beside_ = (folder_ / "camera.yaml").string();
  }
  ~ANamedFile() override { fs::remove_all(folder_); }

  static void write(const fs::path& file, std::string_view text) { std::ofstream(file) << text; }
  std::string refusal_of(const std::string& text) const {
    try {
      place_for(NamedFile::kCalibration, text, config_);
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
      return error.what();
    }
    ADD_FAILURE() << "was not refused: " << text;
    return {};
  }

  fs::path folder_;
  std::string config_, beside_;
};

TEST_F(ANamedFile, GoesWhereTheConfigurationHasIt) {
  fs::create_directory(folder_ / "lenses");
  write(folder_ / "lenses/wide.yaml", "old");
  const FilePlace place =
      place_for(NamedFile::kCalibration, "[camera]\nsource = \"v4l2\"\ncalibration = \"lenses/wide.yaml\"\n", config_);
  EXPECT_EQ(place.path, (folder_ / "lenses/wide.yaml").string());
  EXPECT_EQ(place.config_text, "");
}

TEST_F(ANamedFile, IsTriedUnderANameThatNothingHas) {
  EXPECT_EQ(free_name_beside(beside_), beside_ + ".new");
  write(beside_ + ".new", "somebody's own");
  fs::create_symlink("nowhere", beside_ + ".new2");
  EXPECT_EQ(free_name_beside(beside_), beside_ + ".new3");
}

TEST_F(ANamedFile, IsNamedWhereNoneWasAndNothingElseIsTouched) {
  const FilePlace place = place_for(NamedFile::kCalibration,
                                    "# a sensor\n\n [camera]   # the left one\nsource = \"v4l2\"\n[track]\n", config_);
  EXPECT_EQ(place.path, beside_);
  EXPECT_EQ(place.config_text,
            "# a sensor\n\n [camera]   # the left one\ncalibration = \"camera.yaml\"\nsource = \"v4l2\"\n[track]\n");
  EXPECT_EQ(place_for(NamedFile::kCalibration, "[camera]", config_).config_text,
            "[camera]\ncalibration = \"camera.yaml\"");
  const std::string in_a_string = "[web]\ncertificate = '''\n[camera]\n'''\n";
  EXPECT_EQ(place_for(NamedFile::kCalibration, in_a_string, config_).config_text,
            in_a_string + "\n[camera]\ncalibration = \"camera.yaml\"\n");
}

TEST_F(ANamedFile, IsNotPutWhereSomethingIsOrWhereNobodyKnows) {
  EXPECT_NE(refusal_of("[camera]\ncalibration = \"gone.yaml\"\n").find("gone.yaml"), std::string::npos);
  EXPECT_NE(refusal_of("camera.source = \"v4l2\"\n").find("give [camera] a line of its own"), std::string::npos);
  EXPECT_NE(refusal_of("[camera\n").find("ninedot.toml:"), std::string::npos);
  write(beside_, "of somebody");
  EXPECT_NE(refusal_of("[camera]\n").find("does not name it"), std::string::npos);
  fs::remove(beside_);
  fs::create_symlink("nowhere", beside_);
  EXPECT_NE(refusal_of("[camera]\n").find("does not name it"), std::string::npos);
}

TEST_F(ANamedFile, MayBeAMapWhichTakesThePlaceOfTheLandmarks) {
  const std::string landmarks = "[camera]\n[[landmarks]]\nid = 1\ncode = \"KRGBKKRB\"\n";
  const FilePlace first = place_for(NamedFile::kMap, landmarks, config_);
  EXPECT_EQ(first.path, (folder_ / "map.toml").string());
  EXPECT_EQ(first.config_text, "map = \"map.toml\"\n[camera]\n");
  write(folder_ / "map.toml", "of somebody");
  try {
    place_for(NamedFile::kMap, landmarks, config_);
    ADD_FAILURE() << "nobody knows whose that is";
  } catch (const StartupError& error) {
    EXPECT_NE(std::string(error.what()).find("write `map = \"map.toml\"` at its top"), std::string::npos);
  }
  write(folder_ / "hall.toml", "[[landmarks]]\nid = 1\n");
  const FilePlace next = place_for(NamedFile::kMap, "map = \"hall.toml\"\n[camera]\n", config_);
  EXPECT_EQ(next.path, (folder_ / "hall.toml").string());
  EXPECT_EQ(next.config_text, "");
}

TEST_F(ANamedFile, HasTheRightsOfItsModelAndGoesUnlessItIsKept) {
  write(config_, "");
  fs::permissions(config_, fs::perms(0640));
  {
    const FileOnTrial file(beside_, "new", config_);
    struct stat status {};
    ASSERT_EQ(::stat(beside_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0640U);
  }
  EXPECT_FALSE(fs::exists(beside_));
  {
    FileOnTrial file(beside_, "new", config_);
    file.keep();
  }
  std::ifstream stream(beside_);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), "new");
  EXPECT_THROW(FileOnTrial(folder_ / "none/camera.yaml", "new", config_), StartupError);
}

}  // namespace
}  // namespace ninedot
