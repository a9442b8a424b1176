#include "drivers/servo/visca_pan_tilt.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <numbers>

#include "base/startup_error.h"
#include "base/zoom_stand.h"
#include "drivers/servo/late_pan_tilt.h"
#include "tests/servo/visca_axes.h"
#include "tests/servo/visca_emulated_camera.h"
#include "tests/support/allocation_counter.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using test::EmulatedViscaCamera;
using test::ViscaBytes;

constexpr double kRad = std::numbers::pi / 180;
constexpr double kPanStep_rad = kRad / 8.8, kTiltStep_rad = kRad / 12;

HeadAngles angles_deg(double pan_deg, double tilt_deg) { return {pan_deg * kRad, tilt_deg * kRad}; }

/// Impatient, so that tests are short.
ViscaOptions options_for(const EmulatedViscaCamera& camera) {
  ViscaOptions options;
  options.device = camera.device();
  options.address = camera.address;
  options.poll_interval = 20ms;
  options.reply_timeout = 200ms;
  options.answer_timeout = 2s;
  options.retry_interval = 50ms;
  options.first_reopen_wait = 10ms;
  options.longest_reopen_wait = 100ms;
  return options;
}

bool eventually(const std::function<bool()>& condition, std::chrono::milliseconds timeout = 20s) {
  const auto until = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

/// The head says that it is there, and that all is well.
bool gets_to(const ViscaPanTilt& head, const HeadAngles& angles) {
  return eventually([&] {
    const HeadState state = head.state();
    return !state.failed && std::abs(state.angles.pan_rad - angles.pan_rad) <= 0.51 * kPanStep_rad &&
           std::abs(state.angles.tilt_rad - angles.tilt_rad) <= 0.51 * kTiltStep_rad;
  });
}

std::string refusal(const ViscaOptions& options, ExitStatus status) {
  try {
    const ViscaPanTilt head(options, test::evi_d31_axes());
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, status);
    const std::string line = error.what();
    EXPECT_EQ(line.find('\n'), std::string::npos);
    return line;
  }
  return "started";
}

std::size_t count_of(const std::vector<ViscaBytes>& packets, const std::function<bool(const ViscaBytes&)>& condition) {
  return static_cast<std::size_t>(std::count_if(packets.begin(), packets.end(), condition));
}
bool is_move(const ViscaBytes& packet) { return packet.size() == 15; }
bool is_cancel(const ViscaBytes& packet) { return packet.size() == 3; }

TEST(ViscaPanTilt, SetsAddressesClearsBuffersAsksForThePositionAndStaysThere) {
  EmulatedViscaCamera camera;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  EXPECT_FALSE(head.state().failed);
  EXPECT_TRUE(head.state().measured);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_EQ(count_of(camera.heard(), is_move), 0U) << "where it stands is where it stays";
  head.move_to(angles_deg(-10, 5));
  EXPECT_TRUE(gets_to(head, angles_deg(-10, 5)));
  const std::vector<ViscaBytes> heard = camera.heard();
  ASSERT_GE(heard.size(), 4U);
  EXPECT_EQ(heard[0], (ViscaBytes{0x88, 0x30, 0x01, 0xFF}));
  EXPECT_EQ(heard[1], (ViscaBytes{0x88, 0x01, 0x00, 0x01, 0xFF}));
  EXPECT_EQ(heard[2], (ViscaBytes{0x81, 0x09, 0x06, 0x12, 0xFF}));
  const auto move = std::ranges::find_if(heard, is_move);
  ASSERT_NE(move, heard.end());
  EXPECT_EQ(*move, (ViscaBytes{0x81, 0x01, 0x06, 0x02, 0x18, 0x14, 0, 0, 5, 8, 0, 0, 3, 0x0C, 0xFF}));
}

TEST(ViscaPanTilt, TurnsLeftAndUpForPositiveAngles) {
  EmulatedViscaCamera camera;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  head.move_to(angles_deg(100, 25));
  EXPECT_TRUE(gets_to(head, angles_deg(100, 25)));
  EXPECT_EQ(camera.pan_steps(), -880);  // steps count to the right
  EXPECT_EQ(camera.tilt_steps(), 300);
  EXPECT_FALSE(head.state().limited);
}

TEST(ViscaPanTilt, SaturatesBeyondItsLimitsAndSaysSo) {
  EmulatedViscaCamera camera;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  head.move_to(angles_deg(-140, 0));
  EXPECT_TRUE(head.state().limited);
  head.move_to(angles_deg(-140, 80));
  EXPECT_TRUE(head.state().limited);
  head.move_to(angles_deg(-100, 80));
  EXPECT_TRUE(head.state().limited);
  EXPECT_TRUE(gets_to(head, angles_deg(-100, 25)));
  head.move_to(angles_deg(1, 1));
  EXPECT_FALSE(head.state().limited);
}

TEST(ViscaPanTilt, ReportsWhereTheHeadIsWhileItMoves) {
  EmulatedViscaCamera camera;
  camera.hurry = 1;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  head.move_to(angles_deg(60, 0));  // 0.75 s at 80 deg/s
  double last_rad = -1;
  int positions = 0;
  EXPECT_TRUE(eventually([&] {
    const double pan_rad = head.state().angles.pan_rad;
    EXPECT_GE(pan_rad, last_rad);
    positions += pan_rad > last_rad;
    last_rad = pan_rad;
    return pan_rad > 59.9 * kRad;
  }));
  EXPECT_GT(positions, 5);
}

TEST(ViscaPanTilt, FollowsTheNewestOfManyTargets) {
  EmulatedViscaCamera camera;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  for (int i = 0; i <= 1000; ++i) {
    head.move_to(angles_deg(50 * std::sin(i * 0.01), 20 * std::cos(i * 0.01)));
    std::this_thread::sleep_for(500us);
  }
  EXPECT_TRUE(gets_to(head, angles_deg(50 * std::sin(10), 20 * std::cos(10))));
  EXPECT_LE(camera.most_motions_at_once(), 2);
  EXPECT_EQ(camera.buffer_was_full(), 0);
  EXPECT_LT(count_of(camera.heard(), is_move), 990U);
  EXPECT_EQ(head.losses(), 0U);
}

TEST(ViscaPanTilt, GetsThereWithACameraThatTakesOneMotionAtATime) {
  EmulatedViscaCamera camera;
  camera.hurry = 1;
  camera.faults.one_motion_only = true;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  bool failed = false;
  for (int i = 1; i <= 40; ++i) {
    head.move_to(angles_deg(i, 0));
    std::this_thread::sleep_for(10ms);
    failed |= head.state().failed;
  }
  EXPECT_TRUE(gets_to(head, angles_deg(40, 0)));
  EXPECT_FALSE(failed);
  EXPECT_GT(count_of(camera.heard(), is_cancel), 0U);
}

TEST(ViscaPanTilt, NeverMakesItsCallerWaitOrAllocate) {
  EmulatedViscaCamera camera;
  camera.reply_delay = 60ms;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  camera.faults.silent = true;
  const auto begun = std::chrono::steady_clock::now();
  {
    const test::AllocationGuard guard;
    for (int i = 0; i < 1000; ++i) {
      head.move_to({i * 1e-3, i * 1e-4});
      if (i % 100 == 0) head.stop();
      (void)head.state();
    }
    EXPECT_EQ(guard.allocations(), 0U);
    EXPECT_EQ(guard.releases(), 0U);
  }
  // One answer alone takes 60 ms; the thousand calls would take a minute if they waited.
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 500ms);
}

TEST(ViscaPanTilt, StopEndsAMotionOnItsWay) {
  EmulatedViscaCamera camera;
  camera.hurry = 1;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  head.move_to(angles_deg(90, 0));
  ASSERT_TRUE(eventually([&] { return camera.pan_steps() < -50; }));
  head.stop();
  ASSERT_TRUE(eventually([&] { return camera.is_at_rest(); }, 500ms));
  const double stood_at = camera.pan_steps();
  EXPECT_GT(stood_at, -700);
  std::this_thread::sleep_for(150ms);
  EXPECT_EQ(camera.pan_steps(), stood_at);
  EXPECT_FALSE(head.state().failed);
  head.move_to(angles_deg(90, 0));  // the same target again
  EXPECT_TRUE(gets_to(head, angles_deg(90, 0)));
}

TEST(ViscaPanTilt, HasFailedASecondAfterTheCameraFellSilentAndRecovers) {
  EmulatedViscaCamera camera;
  ViscaOptions options;
  options.device = camera.device();
  ViscaPanTilt head(options, test::evi_d31_axes());
  head.move_to(angles_deg(3, 3));
  ASSERT_TRUE(gets_to(head, angles_deg(3, 3)));
  const auto silent_at = std::chrono::steady_clock::now();
  camera.faults.silent = true;
  ASSERT_TRUE(eventually([&] { return head.state().failed; }, 3s));
  const auto took = std::chrono::steady_clock::now() - silent_at;
  EXPECT_GT(took, 950ms);
  EXPECT_LT(took, 2s);
  EXPECT_NEAR(head.state().angles.pan_rad, 3 * kRad, kPanStep_rad);  // as reported last
  head.move_to(angles_deg(-20, 10));
  camera.faults.silent = false;
  EXPECT_TRUE(gets_to(head, angles_deg(-20, 10)));
  EXPECT_GE(head.losses(), 1U);
}

TEST(ViscaPanTilt, KeepsGoingThroughNoiseHalfPacketsAndLostPackets) {
  EmulatedViscaCamera camera;
  camera.faults.noise = true;
  camera.faults.in_pieces = true;
  camera.faults.lost_packets_percent = 10;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  for (int i = 1; i <= 20; ++i) {
    const HeadAngles target = angles_deg(i % 2 == 0 ? 40 : -40, i);
    head.move_to(target);
    ASSERT_TRUE(gets_to(head, target)) << i;
  }
}

TEST(ViscaPanTilt, HasFailedWhileMotionsAreRefused) {
  EmulatedViscaCamera camera;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  ASSERT_TRUE(gets_to(head, {}));
  camera.faults.not_executable = true;
  head.move_to(angles_deg(5, 5));
  EXPECT_TRUE(eventually([&] { return head.state().failed; }));
  camera.forget_heard();
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < 60; ++i) {
    head.move_to(angles_deg(5 + i % 2, 5));
    std::this_thread::sleep_for(5ms);
  }
  const auto moves = count_of(camera.heard(), is_move);
  // Not at every frame, but at every retry_interval.
  EXPECT_LE(static_cast<double>(moves), (std::chrono::steady_clock::now() - begun) / 50.0ms + 1);
  EXPECT_GE(moves, 2U);
  head.move_to(angles_deg(5, 5));
  camera.faults.not_executable = false;
  EXPECT_TRUE(gets_to(head, angles_deg(5, 5)));
  EXPECT_EQ(head.losses(), 0U);
}

TEST(ViscaPanTilt, ComesBackAfterTheAdapterWasPulledOut) {
  EmulatedViscaCamera camera;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  head.move_to(angles_deg(10, 0));
  ASSERT_TRUE(gets_to(head, angles_deg(10, 0)));
  for (int round = 0; round < 3; ++round) {
    camera.unplug();
    EXPECT_TRUE(eventually([&] { return head.state().failed; }));
    head.move_to(angles_deg(-30 + round, 0));
    std::this_thread::sleep_for(50ms);
    camera.plug();
    EXPECT_TRUE(gets_to(head, angles_deg(-30 + round, 0)));
  }
  EXPECT_GE(head.losses(), 3U);
}

TEST(ViscaPanTilt, SetsAddressesZoomAndTargetAgainAfterAPowerCut) {
  EmulatedViscaCamera camera;
  ViscaOptions options = options_for(camera);
  options.zoom = 500;
  ViscaPanTilt head(options, test::evi_d31_axes());
  head.move_to(angles_deg(10, 0));
  ASSERT_TRUE(gets_to(head, angles_deg(10, 0)));
  camera.power_cycle();
  EXPECT_TRUE(eventually([&] { return camera.zoom() == 500 && camera.pan_steps() == -88; }));
  EXPECT_TRUE(gets_to(head, angles_deg(10, 0)));
}

TEST(ViscaPanTilt, SetsTheZoom) {
  EmulatedViscaCamera camera;
  ViscaOptions options = options_for(camera);
  options.zoom = 400;
  const ViscaPanTilt head(options, test::evi_d31_axes());
  EXPECT_EQ(head.zoom(), 400);
  EXPECT_EQ(camera.zoom(), 400);
}

TEST(ViscaPanTilt, TellsWhereTheZoomStandsAndNothingWhileItMoves) {
  EmulatedViscaCamera camera;
  camera.hurry = 1;
  ViscaOptions options = options_for(camera);
  options.zoom = 20;
  options.zoom_interval = 20ms;
  ViscaPanTilt head(options, test::evi_d31_axes());
  // Asked just before it arrives it is told a step short of it, which is taken for the place where it stands.
  const auto stands_at = [&](int zoom) {
    const auto stand = head.state().zoom;
    return stand && std::abs(stand->position - zoom) <= ZoomAnswers::kSame_steps;
  };
  EXPECT_TRUE(eventually([&] { return stands_at(20); }));
  camera.zoom_by_hand(400);
  EXPECT_TRUE(eventually([&] { return !head.state().zoom; }));
  EXPECT_LT(camera.zoom(), 400) << "told only after it had arrived";
  EXPECT_TRUE(eventually([&] { return stands_at(400); }));
  EXPECT_EQ(camera.zoom(), 400);
  head.move_to(angles_deg(10, 5));
  EXPECT_TRUE(gets_to(head, angles_deg(10, 5)));
  EXPECT_TRUE(stands_at(400));
  camera.unplug();
  EXPECT_TRUE(eventually([&] { return !head.state().zoom; })) << "of a line that is gone";
  camera.plug();
  EXPECT_TRUE(eventually([&] { return stands_at(20); })) << "set again";
}

TEST(ViscaPanTilt, LeavesTheZoomAloneWhereNoneIsWanted) {
  EmulatedViscaCamera camera;
  const ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  EXPECT_FALSE(head.zoom());
  EXPECT_EQ(count_of(camera.heard(), [](const ViscaBytes& packet) { return packet.size() == 9; }), 0U);
}

TEST(ViscaPanTilt, TalksToTheSecondOfThreeCameras) {
  EmulatedViscaCamera camera;
  camera.cameras = 3;
  camera.address = 2;
  ViscaPanTilt head(options_for(camera), test::evi_d31_axes());
  head.move_to(angles_deg(20, 5));
  EXPECT_TRUE(gets_to(head, angles_deg(20, 5)));
}

TEST(ViscaPanTilt, ComesIntoUseWhenItsAdapterIsPluggedInAndItsCameraSwitchedOn) {
  EmulatedViscaCamera camera;
  camera.unplug();
  camera.faults.silent = true;
  ViscaOptions options = options_for(camera);
  options.answer_timeout = 50ms;
  options.reply_timeout = 20ms;
  LatePanTiltOptions late;
  late.reopens_failed = false;
  late.backoff = Backoff(2ms, 20ms);
  LatePanTilt head(
      [&](const HeadAngles& /*at*/) { return std::make_unique<ViscaPanTilt>(options, test::evi_d31_axes()); }, late);
  EXPECT_TRUE(head.state().failed);
  EXPECT_NE(head.problem().find("there is no such serial port"), std::string::npos) << head.problem();
  camera.plug();
  EXPECT_TRUE(eventually([&] { return head.problem().find("no camera answers") != std::string::npos; }));
  EXPECT_TRUE(head.state().failed);
  camera.faults.silent = false;
  EXPECT_TRUE(eventually([&] {
    head.move_to(angles_deg(10, 5));
    return !head.state().failed && camera.pan_steps() == -88;
  }));
  EXPECT_EQ(head.problem(), "");
}

TEST(ViscaPanTilt, EndsAtOnceWhateverTheCameraDoes) {
  EmulatedViscaCamera camera;
  ViscaOptions options = options_for(camera);
  options.reply_timeout = options.answer_timeout = 30s;
  auto head = std::make_unique<ViscaPanTilt>(options, test::evi_d31_axes());
  camera.faults.silent = true;
  head->move_to(angles_deg(1, 1));
  auto begun = std::chrono::steady_clock::now();
  head.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 2s);

  camera.faults.silent = false;
  options.first_reopen_wait = options.longest_reopen_wait = 30s;
  head = std::make_unique<ViscaPanTilt>(options, test::evi_d31_axes());
  camera.unplug();
  ASSERT_TRUE(eventually([&] { return head->state().failed; }));
  begun = std::chrono::steady_clock::now();
  head.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 2s);
}

TEST(ViscaPanTilt, SaysInOneLineWhyItCannotStart) {
  EmulatedViscaCamera camera;
  ViscaOptions options = options_for(camera);
  options.answer_timeout = 200ms;
  options.device = camera.device() + "-none";
  EXPECT_EQ(
      refusal(options, ExitStatus::kWrongUsage),
      options.device + ": there is no such serial port; connect the adapter, or correct the device of [pan_tilt]");
  options.device = camera.device() + "-file";
  std::ofstream(options.device) << "text";
  EXPECT_EQ(refusal(options, ExitStatus::kWrongUsage),
            options.device + ": this is no serial port; correct the device of [pan_tilt]");
  options.device = camera.device();

  camera.faults.silent = true;
  EXPECT_EQ(
      refusal(options, ExitStatus::kWorkFailed),
      options.device + ": no camera answers at address 1; is it switched on, and the cable a crossed one to VISCA IN?");
  camera.faults.silent = false;

  camera.faults.standby = true;
  EXPECT_EQ(refusal(options, ExitStatus::kWorkFailed),
            options.device + ": camera 1 refuses to answer; is it in standby? switch it on");
  camera.faults.standby = false;

  options.address = 2;
  EXPECT_EQ(refusal(options, ExitStatus::kWorkFailed),
            options.device +
                ": the chain ends at address 1, there is no camera 2; correct the address of [pan_tilt], or "
                "connect and switch on what is missing");
  options.address = 1;

  camera.cameras = 0;
  EXPECT_EQ(refusal(options, ExitStatus::kWorkFailed),
            options.device + ": the line brings back what it is sent, without a camera in it; check the cable");
  camera.cameras = 1;

  camera.faults.lens_stuck = true;
  options.zoom = 700;
  options.zoom_timeout = 100ms;
  EXPECT_EQ(refusal(options, ExitStatus::kWorkFailed),
            options.device + ": the lens stands at zoom 0 and does not reach 700; switch the camera off and on");
  camera.faults.lens_stuck = false;
}

TEST(ViscaPanTilt, SaysWhichOptionIsOutOfItsRange) {
  EmulatedViscaCamera camera;
  const auto refused = [&](const std::function<void(ViscaOptions&)>& spoil) {
    ViscaOptions options = options_for(camera);
    spoil(options);
    return refusal(options, ExitStatus::kWrongUsage);
  };
  EXPECT_EQ(refused([](ViscaOptions& options) { options.device.clear(); }),
            "a VISCA head needs the name of its serial port: set the device of [pan_tilt]");
  EXPECT_EQ(refused([](ViscaOptions& options) { options.address = 8; }), "a VISCA camera's address is 1 to 7, not 8");
  EXPECT_EQ(refused([](ViscaOptions& options) { options.pan_speed = 25; }),
            "a VISCA camera's pan speed is 1 to 24, not 25");
  EXPECT_EQ(refused([](ViscaOptions& options) { options.tilt_speed = 0; }),
            "a VISCA camera's tilt speed is 1 to 20, not 0");
  EXPECT_EQ(refused([](ViscaOptions& options) { options.zoom = 1024; }), "this camera's zoom is 0 to 1023, not 1024");
}

/// A line that sends, and nothing of VISCA.
TEST(ViscaPanTilt, TellsAWrongBaudRateFromASilentCamera) {
  EmulatedViscaCamera camera;
  camera.faults.noise = true;
  camera.cameras = 9;  // its answers make no sense
  ViscaOptions options = options_for(camera);
  options.answer_timeout = 200ms;
  EXPECT_EQ(
      refusal(options, ExitStatus::kWorkFailed),
      options.device + ": what arrives is not VISCA at 9600 baud; set the camera to 9600 baud and check the cable");
}

TEST(ViscaPanTilt, AsksTenTimesASecondAlsoWhenEveryFrameHasATarget) {
  EmulatedViscaCamera camera;
  camera.hurry = 1;
  camera.reply_delay = 20ms;  // a field of the picture
  camera.at_9600_baud = true;
  ViscaOptions options;
  options.device = camera.device();
  ViscaPanTilt head(options, test::evi_d31_axes());
  ASSERT_TRUE(gets_to(head, {}));
  camera.forget_heard();
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < 105; ++i) {  // 3 s of frames
    head.move_to(angles_deg(30 * std::sin(i * 0.06), 0));
    std::this_thread::sleep_until(begun + i * 28571us);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  const std::vector<ViscaBytes> heard = camera.heard();
  const auto questions =
      static_cast<double>(count_of(heard, [](const ViscaBytes& packet) { return packet.size() == 5; }));
  const auto moves = static_cast<double>(count_of(heard, is_move));
  RecordProperty("questions_per_s", std::to_string(questions / seconds));
  RecordProperty("moves_per_s", std::to_string(moves / seconds));
  std::printf("questions %.1f/s, motions %.1f/s, cancels %.1f/s\n", questions / seconds, moves / seconds,
              static_cast<double>(count_of(heard, is_cancel)) / seconds);
  EXPECT_GT(questions / seconds, 6);
  EXPECT_LT(questions / seconds, 11);
  EXPECT_GT(moves / seconds, 3);
}

}  // namespace
}  // namespace ninedot
