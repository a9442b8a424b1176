// What commands of `ninedot` read and write, as it is typed: nothing of a person's is lost by a slip.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "base/startup_error.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/commands.h"
#include "tests/programs/typed_command.h"
#include "tests/recording/temporary_recording.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

class CommandFiles : public testing::Test {
 protected:
  CommandFiles() {
    folder_.write("frames.csv", "frame,timestamp_ns\n0,0\n1,30000000\n");
    const std::string camera =
        "image_width: 8\nimage_height: 4\ncamera_name: test\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [8, 0, 3.5, "
        "0, 8, 1.5, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, "
        "0, 0, 0, 0]\n";
    folder_.write("camera.yaml", camera);
    folder_.write("other.yaml", camera);
    folder_.write("hall.toml",
                  "[[landmarks]]\nid = 1\ncode = \"KRGBKKRB\"\nposition_mm = [0, 0, 0]\n"
                  "[[landmarks]]\nid = 2\ncode = \"RRGKBGKB\"\nposition_mm = [700, 0, 0]\n");
    folder_.write("c.toml", "map = \"hall.toml\"\n[camera]\ncalibration = \"other.yaml\"\n[tap]\nenabled = true\n");
  }

  std::string in(const std::string& name) const { return folder_.path() + "/" + name; }
  std::string text_of(const std::string& name) const {
    if (fs::is_directory(in(name))) return {};
    std::ifstream stream(in(name));
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  test::TypedOutcome replay(const Words& more) const { return type(add_replay_command, {"replay"}, more); }
  test::TypedOutcome map(const Words& more) const {
    return type(add_map_command, {"map", folder_.path(), "--config", in("c.toml"), "--origin", "1"}, more);
  }
  static test::TypedOutcome type(void (*add)(CLI::App&), Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return test::type_command(add, std::move(words));
  }
  static void expect_usage(const test::TypedOutcome& outcome, const std::string& what) {
    test::expect_refusal(outcome, ExitStatus::kWrongUsage, what);
  }
  std::string read_by(const std::string& name, const std::string& option) const {
    return in(name) + " is read by this command: give " + option + " another name";
  }

  TemporaryRecording folder_{2};
};

TEST_F(CommandFiles, ReplayWritesOverNothingThatItReads) {
  ASSERT_EQ(replay({folder_.path(), "--config", in("c.toml"), "--out", in("poses.csv")}).status, ExitStatus::kSuccess);
  const std::vector<std::pair<std::string, std::string>> slips{
      {"--out", "frames.csv"},      {"--out", "frames/000001.pgm"}, {"--out-world", "c.toml"},
      {"--out-track", "hall.toml"}, {"--out", "camera.yaml"},       {"--overlay", "frames"}};
  for (const auto& [option, name] : slips) {
    const std::string before = text_of(name);
    expect_usage(replay({folder_.path(), "--config", in("c.toml"), option, in(name)}), read_by(name, option));
    EXPECT_EQ(text_of(name), before) << name;
  }
  expect_usage(replay({folder_.path(), "--camera", in("other.yaml"), "--out", in("other.yaml")}),
               read_by("other.yaml", "--out"));
  fs::remove(in("camera.yaml"));
  expect_usage(replay({folder_.path(), "--config", in("c.toml"), "--out", in("other.yaml")}),
               read_by("other.yaml", "--out"));
  EXPECT_FALSE(fs::exists(in("frames/000000.png"))) << "an overlay";
}

TEST_F(CommandFiles, ReplayGivesEachOutputAPlaceOfItsOwn) {
  expect_usage(replay({folder_.path(), "--out", in("one.csv"), "--out-world", in("./one.csv")}),
               "would be written twice, by --out and by --out-world");
  expect_usage(replay({folder_.path(), "--out-world", in("one.csv"), "--out-track", in("one.csv")}),
               "would be written twice");
  for (const Words& all : {Words{"--out", "-", "--out-world", "-"}, Words{"--out-track", "-"}})
    expect_usage(type(add_replay_command, {"replay", folder_.path()}, all),
                 "standard output would be written twice, by --out and by --out-");
  EXPECT_FALSE(fs::exists(in("one.csv")));
}

TEST_F(CommandFiles, ReplayLeavesNoneOfItsFilesWhereOneCanNotBeWritten) {
  folder_.write("poses.csv", "before");
  test::expect_refusal(replay({folder_.path(), "--out", in("poses.csv"), "--out-track", "/dev/full"}),
                       ExitStatus::kWorkFailed, "No space left");
  EXPECT_EQ(text_of("poses.csv"), "before");
}

TEST_F(CommandFiles, MapWritesOverNothingThatItReadsButTheMapBefore) {
  const std::string config = text_of("c.toml");
  expect_usage(map({"--out", in("c.toml")}), read_by("c.toml", "--out"));
  expect_usage(map({"--out", in("frames.csv")}), read_by("frames.csv", "--out"));
  expect_usage(map({"--out", in("camera.yaml")}), read_by("camera.yaml", "--out"));
  expect_usage(map({"--out", in("new.toml"), "--plan", in("hall.toml")}), read_by("hall.toml", "--plan"));
  expect_usage(map({"--out", in("new.toml"), "--camera", in("other.yaml"), "--plan", in("other.yaml")}),
               read_by("other.yaml", "--plan"));
  EXPECT_EQ(text_of("c.toml"), config);
  test::expect_refusal(map({"--out", in("hall.toml")}), ExitStatus::kWorkFailed, "no picture shows");
}

TEST_F(CommandFiles, MapGivesEachOutputAPlaceOfItsOwn) {
  expect_usage(map({"--out", in("new.toml"), "--plan", in("new.toml")}), "would be written twice, by --out and by");
  expect_usage(map({"--out", "-", "--plan", "-"}), "standard output would be written twice, by --out and by --plan");
  testing::internal::CaptureStdout();
  expect_usage(map({"--out", in("new.toml"), "--plan", "-", "--progress", "json"}),
               "--progress and --plan - would both write to standard output");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST_F(CommandFiles, OtherCommandsWriteOverNothingThatTheyRead) {
  folder_.write("scenario.toml",
                "map = \"hall.toml\"\n[simulation]\nduration_s = 0.1\n[[simulation.robot]]\nt_s = 0\ny_mm = 1500\n");
  for (const std::string name : {"scenario.toml", "hall.toml"})
    expect_usage(type(add_simulate_command, {"simulate", in("scenario.toml")}, {"--out", in(name)}),
                 read_by(name, "--out"));
  folder_.write("c.pdf", text_of("c.toml"));
  folder_.write("hall.pdf", text_of("hall.toml"));
  expect_usage(type(add_pattern_command, {"pattern", "--all", "--config", in("c.pdf")}, {"--out", in("c.pdf")}),
               read_by("c.pdf", "--out"));
  folder_.write("c.toml", "map = \"hall.pdf\"\n[tap]\nenabled = true\n[camera]\ncalibration = \"other.yaml\"\n");
  expect_usage(type(add_pattern_command, {"pattern", "--all", "--config", in("c.toml")}, {"--out", in("hall.pdf")}),
               read_by("hall.pdf", "--out"));
  for (const std::string command : {"rolling-shutter", "pan-tilt"})
    expect_usage(type(add_calibrate_command, {"calibrate", command, folder_.path(), "--config", in("c.toml")},
                      {"--out", in("camera.yaml")}),
                 read_by("camera.yaml", "--out"));
  expect_usage(type(add_tap_command, {"tap", "--config", in("c.toml")}, {"--out", in("c.toml")}),
               read_by("c.toml", "--out"));
}

/// Of a script whose variable is empty.
TEST_F(CommandFiles, AnEmptyNameIsNone) {
  for (const std::string option : {"--config", "--camera", "--out", "--out-world", "--out-track", "--overlay"})
    EXPECT_THROW(replay({folder_.path(), option, ""}), CLI::ValidationError) << option;
  EXPECT_THROW(replay({""}), CLI::ValidationError);
  EXPECT_THROW(map({"--out", ""}), CLI::ValidationError);
  for (const std::string option : {"--camera", "--plan"})
    EXPECT_THROW(map({"--out", in("new.toml"), option, ""}), CLI::ValidationError) << option;
  EXPECT_THROW(map({"--out", in("new.toml"), ""}), CLI::ValidationError) << "a second recording";
  EXPECT_THROW(type(add_simulate_command, {"simulate", in("c.toml")}, {"--out", ""}), CLI::ValidationError);
  EXPECT_THROW(type(add_record_command, {"record", "--config", in("c.toml")}, {"--out", ""}), CLI::ValidationError);
  EXPECT_THROW(type(add_pattern_command, {"pattern"}, {"--out", ""}), CLI::ValidationError);
  EXPECT_THROW(type(add_tap_command, {"tap"}, {"--out", ""}), CLI::ValidationError);
}

TEST_F(CommandFiles, WhatIsNoRecordingWasNamedByMistake) {
  fs::create_directories(in("empty/frames"));
  for (const std::string name : {"empty", "frames.csv", "nowhere"}) {
    expect_usage(replay({in(name), "--out", in("poses.csv")}), in(name));
    expect_usage(map({"--out", in("new.toml"), in(name)}), in(name));
  }
  EXPECT_FALSE(fs::exists(in("poses.csv")));
  folder_.write("frames/000001.pgm", "P5 8 4 255\nshort");
  test::expect_refusal(replay({folder_.path(), "--out", in("poses.csv")}), ExitStatus::kWorkFailed, "000001.pgm");
}

TEST_F(CommandFiles, ARecordingCountsOnceInAMap) {
  fs::create_directory_symlink(folder_.path(), in("again"));
  expect_usage(map({"--out", in("new.toml"), in("again")}), in("again") + " is given twice");
  expect_usage(map({"--out", in("new.toml"), "--origin", "1"}), "--origin 1: is named twice");
}

TEST_F(CommandFiles, AMapIsReadFromWhereWhoeverNamedItSeesIt) {
  const fs::path here = fs::current_path();
  fs::current_path(fs::path(folder_.path()).parent_path());
  const std::string site = fs::path(folder_.path()).filename().string();
  ConfigProblems problems;
  const Config config = read_config("map = \"gone.toml\"\n", "new", site + "/c.toml", problems, site + "/hall.toml");
  fs::current_path(here);
  EXPECT_TRUE(problems.list.empty()) << problems.list.front().what;
  EXPECT_EQ(config.landmarks.size(), 2U);
}

TEST_F(CommandFiles, APlanIsAnSvgByItsNameToo) {
  for (const std::string name : {"plan.png", "plan", "svg", ".svg"})
    expect_usage(map({"--out", in("new.toml"), "--plan", in(name)}),
                 "--plan " + in(name) + ": end the file's name with .svg");
  EXPECT_FALSE(fs::exists(in("plan.png")));
  EXPECT_FALSE(fs::exists(in("new.toml")));
}

TEST_F(CommandFiles, ACalibrationOfAnotherCameraThanTheRecordingsIsRefused) {
  const auto of_camera = [&](const std::string& name, const std::string& id) {
    folder_.write(name, text_of("plain.yaml") + "calibration:\n  camera_id: \"" + id + "\"\n");
  };
  folder_.write("plain.yaml", text_of("other.yaml"));
  const auto status = [&] {
    return replay({folder_.path(), "--camera", in("other.yaml"), "--out", in("poses.csv")}).line;
  };
  of_camera("camera.yaml", "usb-046d:0825-1A2B3C");
  of_camera("other.yaml", "usb-046d:0825-77");
  expect_usage(map({"--out", in("new.toml"), "--camera", in("other.yaml")}),
               "is of the camera usb-046d:0825-77, but " + in("camera.yaml") +
                   " says that the recording is of usb-046d:0825-1A2B3C");
  EXPECT_NE(status().find("is of the camera"), std::string::npos);
  of_camera("other.yaml", "");
  EXPECT_EQ(status().find("is of the camera"), std::string::npos) << "nobody knows";
  of_camera("other.yaml", "usb-046d:0825");
  EXPECT_EQ(status().find("is of the camera"), std::string::npos) << "a serial number that one of them lacks";
  of_camera("other.yaml", "usb-046d:0825-77");
  folder_.write("camera.yaml", "damaged");
  EXPECT_EQ(status().find("is of the camera"), std::string::npos) << "that is why another is given";
}

TEST(SimulateCommand, TakesWholeNumbersAsSeeds) {
  const auto refusal = [](const std::string& seed) -> std::string {
    try {
      return test::type_command(add_simulate_command, {"simulate", "/nowhere.toml", "--seed=" + seed}).line;
    } catch (const CLI::ParseError& error) {
      return error.what();
    }
  };
  for (const std::string seed : {"-1", " -1", "1.5", "1x", "0x10", "18446744073709551616"})
    EXPECT_EQ(refusal(seed), "--seed: '" + seed + "' is no seed: give a whole number, 0 to 18446744073709551615");
  for (const std::string seed : {"0", "18446744073709551615"})
    EXPECT_NE(refusal(seed).find("/nowhere.toml"), std::string::npos) << seed;
}

}  // namespace
}  // namespace ninedot
