// Between taking a frame and publishing its report nothing is allocated: every bundled recording, both solvers, with
// and without tracking, from the very first frame on.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "calibrate/camera_file.h"
#include "drivers/recording/recording_source.h"
#include "drivers/servo/simulated_pan_tilt.h"
#include "outputs/head_output.h"
#include "pipeline/frame_loop.h"
#include "pipeline/localiser.h"
#include "programs/assembly/input_files.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/process_picture.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

std::vector<std::string> bundled_recordings() {
  std::vector<std::string> folders;
  for (const auto& entry : std::filesystem::directory_iterator(NINEDOT_SOURCE_DIR "/tests/recordings"))
    if (std::filesystem::exists(entry.path() / "frames")) folders.push_back(entry.path().string());
  return folders;
}

ServoAxes straight_axes() {
  constexpr std::array kPoints{AxisPoint{-1, 1000}, AxisPoint{1, 2000}};
  return {ServoAxis(kPoints, 1000, 2000), ServoAxis(kPoints, 1000, 2000)};
}

struct Outcome {
  std::uint64_t frames = 0, found = 0;
};

Outcome run_and_count(const std::string& recording, Solver solver, bool tracking) {
  RecordingSource source(recording, {});
  Localiser localiser(read_camera_file(recording_camera_file(recording)),
                      {.seeker = {.solver = solver}, .tracking = tracking});
  Mailbox<Report> reports;
  Mailbox<Health> health;
  SimulatedPanTilt servos(straight_axes(), {});
  HeadOutput head(read_camera_file(recording_camera_file(recording)), {}, servos, nullptr, {});
  FrameLoop loop(source, localiser, reports, health,
                 {.health_period = std::chrono::nanoseconds(1), .head = &head.snapshots()});
  Outcome outcome;
  for (bool goes_on = true; goes_on;) {
    const std::uint64_t frames_before = loop.frames_processed();
    {
      const test::AllocationGuard guard;
      goes_on = loop.step();
      head.take(reports.read(), true, mono_now());  // in the service: in a thread of its own
      EXPECT_EQ(guard.allocations(), 0U) << recording << ", frame " << outcome.frames;
      EXPECT_EQ(guard.releases(), 0U) << recording << ", frame " << outcome.frames;
    }
    outcome.frames += loop.frames_processed() - frames_before;
    if (loop.frames_processed() != frames_before && reports.read().found) ++outcome.found;
  }
  return outcome;
}

TEST(FramePath, AllocatesNothingOverEveryBundledRecordingWithBothSolvers) {
  const std::vector<std::string> recordings = bundled_recordings();
  ASSERT_GE(recordings.size(), 2U);
  for (const std::string& recording : recordings)
    for (const Solver solver : {Solver::kFull, Solver::kEllipse})
      for (const bool tracking : {true, false}) {
        SCOPED_TRACE(recording + (solver == Solver::kFull ? ", full" : ", ellipse"));
        const Outcome outcome = run_and_count(recording, solver, tracking);
        EXPECT_GT(outcome.frames, 0U);
        // A path that never finds anything would not be the path that matters.
        const bool shows_the_landmark = recording.find("approach") != std::string::npos;
        EXPECT_TRUE(!shows_the_landmark || outcome.found > outcome.frames / 2) << outcome.found;
      }
}

TEST(FramePath, AllocatesNothingWhileItFollowsAStillLandmark) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.5, .tilt_rad = 0.4});
  const test::Picture picture = test::render(scene, 1);
  Localiser localiser(CameraModel{}, {});
  Report report;
  for (int i = 0; i < 5; ++i) {
    const test::AllocationGuard guard;
    test::process_picture(localiser, picture.view(), MonoTime(std::chrono::seconds(i + 1)),
                          static_cast<std::uint64_t>(i), report);
    EXPECT_EQ(guard.allocations(), 0U) << i;
    EXPECT_EQ(report.tracking, i > 0);
  }
}

}  // namespace
}  // namespace ninedot
