#include "programs/commands/output_check.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/startup_error.h"
#include "tests/recording/temporary_recording.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

class OutputCheck : public testing::Test {
 protected:
  std::string in(const std::string& name) const { return folder_.path() + "/" + name; }
  static std::string refusal(const std::vector<NamedOutput>& outputs, const std::vector<std::string>& inputs) {
    try {
      check_outputs(outputs, inputs);
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
      return error.what();
    }
    return "none";
  }

  TemporaryRecording folder_{1};
};

TEST_F(OutputCheck, RefusesWhatIsRead) {
  folder_.write("c.toml", "");
  EXPECT_EQ(refusal({{"--out", in("c.toml")}}, {in("c.toml")}),
            in("c.toml") + " is read by this command: give --out another name");
  fs::create_symlink(in("c.toml"), in("link.toml"));
  EXPECT_NE(refusal({{"--out", in("link.toml")}}, {"", in("c.toml")}), "none");
  EXPECT_NE(refusal({{"--out", in("../" + fs::path(folder_.path()).filename().string() + "/c.toml")}}, {in("c.toml")}),
            "none");
  EXPECT_EQ(refusal({{"--out", in("d.toml")}}, {in("c.toml"), ""}), "none");
}

TEST_F(OutputCheck, RefusesAPlaceAmongARecordingsPicturesButNotItsCalibration) {
  EXPECT_NE(refusal({{"--out", in("frames/000000.png")}}, {folder_.path()}), "none");
  EXPECT_NE(refusal({{"--overlay", in("frames")}}, {folder_.path()}), "none");
  EXPECT_NE(refusal({{"--picture", in("frames.csv")}}, {folder_.path()}), "none");
  EXPECT_EQ(refusal({{"--out", in("camera.yaml")}, {"--picture", in("camera.svg")}}, {folder_.path()}), "none");
}

TEST_F(OutputCheck, RefusesOneFileForTwoOutputs) {
  EXPECT_EQ(refusal({{"--out", "a.svg"}, {"--picture", "./a.svg"}}, {}),
            "./a.svg would be written twice, by --out and by --picture: name two files");
  EXPECT_EQ(refusal({{"--out", "-"}, {"--picture", "-"}}, {}),
            "standard output would be written twice, by --out and by --picture: name two files");
  EXPECT_EQ(refusal({{"--out", "-"}, {"--picture", "a.svg"}}, {}), "none");
  EXPECT_EQ(refusal({{"--out", ""}, {"--picture", ""}}, {}), "none");
  EXPECT_EQ(refusal({{"--out", "/dev/null"}, {"--picture", "/dev/null"}}, {}), "none");
}

TEST_F(OutputCheck, WantsANameWhereThereMustBeOne) {
  EXPECT_NO_THROW(check_named({"--out", "-"}));
  EXPECT_THROW(check_named({"--out", ""}), StartupError);
}

}  // namespace
}  // namespace ninedot
