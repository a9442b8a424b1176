#include "drivers/camera/media_sensor.h"

#include <gtest/gtest.h>

#include "drivers/camera/v4l2_device.h"
#include "drivers/camera/v4l2_list.h"
#include "fake_media_kernel.h"
#include "tests/support/allocation_counter.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

struct Board {
  explicit Board(FakeSensor sensor, int width_px, int height_px, double rate_hz) : kernel(std::move(sensor)) {
    request.device = "sensor:" + kernel.sensor.name.substr(0, 6);
    request.width_px = width_px, request.height_px = height_px;
    request.rate_hz = rate_hz;
  }
  V4l2Device& device() {
    if (!device_) device_.emplace(request, kernel, kernel.folders);
    return *device_;
  }
  V4l2Device& opened() {
    device().open();
    return device();
  }
  std::string refusal(int* error = nullptr) {
    try {
      device().open();
    } catch (const CameraRefused& refused) {
      EXPECT_FALSE(kernel.video.is_open) << "a refused camera is closed again";
      EXPECT_EQ(kernel.open_nodes, 0) << "and so are the sensor's, the receiver's and the graph's nodes";
      if (error != nullptr) *error = refused.os_errno;
      EXPECT_EQ(std::string(refused.what()).find('\n'), std::string::npos);
      return refused.what();
    }
    return "no refusal";
  }

  FakeMediaKernel kernel;
  CameraRequest request;

 private:
  std::optional<V4l2Device> device_;
};

Board ov9281(double rate_hz = 72) { return Board(fake_ov9281(), 1280, 800, rate_hz); }
Board imx296(double rate_hz = 60) { return Board(fake_imx296(), 1456, 1088, rate_hz); }

// 0x2001 and 0x200a: MEDIA_BUS_FMT_Y8_1X8 and Y10_1X10. Pad 0 of the receiver takes pictures, pad 1 gives them.
TEST(MediaSensor, SetsTheWholePathFromTheSensorDownInTheOrderInWhichOneLimitsTheNext) {
  Board board(fake_ov9281(), 1280, 800, 100);
  board.request.exposure = 2ms;
  board.request.gain = 32;
  board.opened();
  // A line of (1280 + 250) / 200 MHz = 7.65 us; 10 ms are 1307.2 of them, 800 for the picture; 2 ms are 261.4.
  EXPECT_EQ(board.kernel.done, (Lines{"sensor:0 0x2001 1280x800", "receiver:0 0x2001 1280x800",
                                      "receiver:1 0x2001 1280x800", "vblank 507", "exposure 261", "gain 32"}));
  EXPECT_EQ(board.device().description(),
            "GREY 1280x800, 100 Hz, exposure 1996.65 us, gain 32, ov9281 10-0060 -> unicam -> " +
                board.kernel.folders.devices + "/video0, global shutter, line time 7.65 us");
  EXPECT_TRUE(board.kernel.video.is_streaming);
}

TEST(MediaSensor, TenBitsOfAnOv9281TakeLongerLines) {
  Board board = ov9281(50);
  board.request.pixel_format = "Y10";
  board.request.exposure = 1ms;
  board.opened();
  EXPECT_EQ(board.kernel.code, MEDIA_BUS_FMT_Y10_1X10);
  // 1530 / 160 MHz = 9.5625 us: 2091.5 lines a frame, 104.6 of exposure.
  EXPECT_EQ(board.kernel.values[V4L2_CID_VBLANK], 2092 - 800);
  EXPECT_EQ(board.kernel.values[V4L2_CID_EXPOSURE], 105);
}

TEST(MediaSensor, ARateThatASensorDoesNotReachIsItsNearestAndSaidSo) {
  Board fast = ov9281(200);
  fast.opened();
  EXPECT_EQ(fast.kernel.values[V4L2_CID_VBLANK], 110);
  // 1 / (910 lines of 7.65 us)
  EXPECT_NE(fast.device().description().find("143.6 Hz (asked 200)"), std::string::npos) << fast.device().description();
  EXPECT_EQ(fast.device().frame_period(), 910 * 7650ns);
  Board slow = ov9281(2);
  slow.opened();
  EXPECT_EQ(slow.kernel.values[V4L2_CID_VBLANK], 51540);
  EXPECT_NE(slow.device().description().find("2.497 Hz (asked 2)"), std::string::npos) << slow.device().description();
}

TEST(MediaSensor, AnImx296GivesItsSixtyHertzAndItsLineInPixelsOfANominalRate) {
  Board board = imx296(60);
  board.request.exposure = 5ms;
  board.request.gain = 100;
  board.opened();
  // 1760 / 118.8 MHz = 14.8148 us, which is HMAX 1100 at 74.25 MHz: 1125 lines of 60 Hz.
  EXPECT_EQ(board.kernel.done,
            (Lines{"crop 1456x1088 at 0,0", "sensor:0 0x200a 1456x1088", "receiver:0 0x200a 1456x1088",
                   "receiver:1 0x200a 1456x1088", "vblank 37", "exposure 338", "gain 100"}));
  EXPECT_NE(board.device().description().find("Y10 1456x1088, 60 Hz, exposure 5007.41 us, gain 100"), std::string::npos)
      << board.device().description();
}

TEST(MediaSensor, AnExposureLongerThanAFrameEndsWithItThoughTheDriversRangeDoesNotSaySo) {
  Board board = imx296(60);
  board.request.exposure = 40ms;
  board.opened();
  EXPECT_EQ(board.kernel.values[V4L2_CID_EXPOSURE], 1125);
  EXPECT_NE(board.device().description().find("exposure 16666.7 us (asked 40000)"), std::string::npos)
      << board.device().description();
  Board ov = ov9281(100);
  ov.request.exposure = 40ms;
  ov.opened();
  EXPECT_EQ(ov.kernel.values[V4L2_CID_EXPOSURE], 1307 - 25) << "the driver's range follows the blanking";
  Board fast = Board(fake_ov9281(), 640, 400, 300);
  fast.request.exposure = 40ms;
  fast.opened();
  EXPECT_EQ(fast.kernel.values[V4L2_CID_EXPOSURE], 436) << "there it does not";
}

TEST(MediaSensor, BinnedAnImx296KeepsTheLineOfItsWholeWidth) {
  Board board(fake_imx296(), 728, 544, 100);
  board.opened();
  EXPECT_EQ(board.kernel.done.front(), "crop 1456x1088 at 0,0") << "all of the view";
  // 10 ms / 14.8148 us = 675 lines
  EXPECT_EQ(board.kernel.values[V4L2_CID_VBLANK], 675 - 544);
}

TEST(MediaSensor, ASizeThatIsNotListedIsCutOutOfTheMiddleAndTakenBackForOneThatIs) {
  Board board(fake_imx296(), 640, 480, 60);
  board.opened();
  EXPECT_EQ(board.kernel.done.front(), "crop 640x480 at 408,304");
  EXPECT_EQ(board.kernel.done[1], "sensor:0 0x200a 640x480");
  board.device().close();
  board.kernel.done.clear();
  CameraRequest whole = board.request;
  whole.width_px = 1456, whole.height_px = 1088;
  V4l2Device device(whole, board.kernel, board.kernel.folders);
  device.open();
  EXPECT_EQ(board.kernel.done.front(), "crop 1456x1088 at 0,0");

  Board uncut = Board(fake_ov9281(), 640, 480, 60);
  EXPECT_EQ(
      uncut.refusal(),
      "sensor:ov9281: the camera has no readable format at 640x480; it offers GREY, Y10P, Y10 1280x800, 1280x720, "
      "640x400");
}

TEST(MediaSensor, EverythingIsSetAnewAtEachOpening) {
  Board board = ov9281(100);
  board.request.exposure = 2ms;
  board.request.gain = 32;
  board.opened();
  const Lines first = board.kernel.done;
  board.device().close();
  // Without power it forgot; and somebody made its lines longer.
  board.kernel.done.clear();
  board.kernel.values[V4L2_CID_EXPOSURE] = 642, board.kernel.values[V4L2_CID_ANALOGUE_GAIN] = 16;
  board.kernel.values[V4L2_CID_VBLANK] = 1022;
  board.device().open();
  EXPECT_EQ(board.kernel.done, first);
  board.device().close();
  board.kernel.sensor.modes.front().hblank = 250;
  board.kernel.change_format = [&](v4l2_mbus_framefmt&, int fd) {
    if (fd == FakeMediaKernel::kReceiverFd) board.kernel.values[V4L2_CID_HBLANK] = 900;
  };
  board.kernel.done.clear();
  board.device().open();
  EXPECT_NE(std::ranges::find(board.kernel.done, "hblank 250"), board.kernel.done.end());
  EXPECT_EQ(board.kernel.values[V4L2_CID_VBLANK], 507);
}

TEST(MediaSensor, TheMiddleOfTheExposureFollowsWhatTheSensorHas) {
  Board board = ov9281(100);
  board.request.exposure = 2ms;
  V4l2Device& device = board.opened();
  const MonoTime stamp = std::chrono::floor<std::chrono::microseconds>(mono_now()) - 1ms;
  const auto middle = [&](MonoTime stamped) {
    board.kernel.video.deliver({.stamp = stamped});
    const Result<GrabbedFrame> frame = device.grab(mono_now() + 1s);
    EXPECT_TRUE(frame);
    device.release(frame->buffer);
    return frame->frame.exposed_at();
  };
  EXPECT_EQ(middle(stamp), stamp - 261 * 7650ns / 2);
  board.kernel.values[V4L2_CID_EXPOSURE] = 100;  // through the sensor's own node, by somebody else
  EXPECT_EQ(device.refresh(), V4l2Device::kRefreshPause);
  EXPECT_EQ(middle(stamp + 1us), stamp + 1us - 100 * 7650ns / 2);
}

TEST(MediaSensor, AnExposureThatTheDriverCutsWhenItStartsIsTheOneOfTheStamps) {
  Board board = ov9281(100);
  board.request.exposure = 2ms;
  board.kernel.exposure_with_power = 200;
  V4l2Device& device = board.opened();
  const MonoTime stamp = std::chrono::floor<std::chrono::microseconds>(mono_now()) - 1ms;
  board.kernel.video.deliver({.stamp = stamp});
  const Result<GrabbedFrame> frame = device.grab(mono_now() + 1s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.exposed_at(), stamp - 200 * 7650ns / 2);
}

TEST(MediaSensor, WhatIsNotAskedForStaysAndIsSaid) {
  Board board = ov9281(72);
  board.opened();
  for (const std::string& line : board.kernel.done) EXPECT_EQ(line.find("exposure"), std::string::npos) << line;
  EXPECT_NE(board.device().description().find("exposure 4911.3 us as it was, gain 16 as it was"), std::string::npos)
      << board.device().description();
}

TEST(MediaSensor, AnAutomaticIsSwitchedOffBeforeAndNotAfter) {
  Board board = ov9281(100);  // as ov5647.c has it
  board.kernel.set_range(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_AUTO);
  board.request.exposure = 2ms;
  board.opened();
  const Lines& done = board.kernel.done;
  const auto off = std::ranges::find(done, "automatic 1"), set = std::ranges::find(done, "exposure 261");
  EXPECT_TRUE(off < set && set != done.end());
}

TEST(MediaSensor, GrabsWithoutTheHeap) {
  Board board = ov9281(72);
  V4l2Device& device = board.opened();
  for (std::uint32_t i = 0; i < 20; ++i) {
    board.kernel.video.deliver({.sequence = i, .stamp = mono_now()});
    const test::AllocationGuard guard;
    const Result<GrabbedFrame> frame = device.grab(mono_now());
    ASSERT_TRUE(frame);
    device.release(frame->buffer);
    EXPECT_EQ(guard.allocations() + guard.releases(), 0U);
  }
}

TEST(MediaSensor, ALinkThatIsOffIsSwitchedOnAndItsRivalOff) {
  Board board = ov9281();
  board.request.device = "sensor:OV9281 10";
  board.kernel.has_second = true;
  board.kernel.sensor_link = 0, board.kernel.second_link = MEDIA_LNK_FL_ENABLED;
  board.opened();
  EXPECT_EQ(board.kernel.done[0], "link 15:0 -> 3:0 off");
  EXPECT_EQ(board.kernel.done[1], "link 1:0 -> 3:0 on");
  board.device().close();

  Board refused = ov9281();
  refused.kernel.sensor_link = 0;
  refused.kernel.refusals[MEDIA_IOC_SETUP_LINK] = EBUSY;
  EXPECT_EQ(refused.refusal(),
            "sensor:ov9281: the link from 'ov9281 10-0060' to 'unicam' can't be switched on: Device or resource busy: "
            "stop the program that uses the camera (fuser /dev/video* names it)");
  Board fixed = ov9281();
  fixed.kernel.sensor_link = MEDIA_LNK_FL_IMMUTABLE;
  EXPECT_EQ(fixed.refusal(),
            "sensor:ov9281: no link leads from 'ov9281 10-0060' to a node that captures pictures: "
            "`media-ctl -p -d " +
                fixed.kernel.folders.devices + "/media0` shows what is connected");
}

TEST(MediaSensor, OfSeveralOneMustBeNamed) {
  Board board = ov9281();
  board.kernel.has_second = true;
  int error = 0;
  EXPECT_EQ(board.refusal(&error),
            "sensor:ov9281: several sensors' names begin so: write one of "
            "'sensor:ov9281 10-0060', 'sensor:ov9281 11-0060'");
  EXPECT_EQ(error, EINVAL);
}

TEST(MediaSensor, OneThatIsNotThereIsWaitedFor) {
  Board other = ov9281();
  other.request.device = "sensor:imx296";
  int error = 0;
  EXPECT_EQ(other.refusal(&error), "sensor:imx296: no sensor's name begins so; there is 'sensor:ov9281 10-0060'");
  EXPECT_EQ(error, ENODEV);
  Board none = ov9281();
  none.kernel.is_sensor_there = false;
  EXPECT_EQ(none.refusal(&error),
            "sensor:ov9281: there is no sensor: connect it; its driver says in dmesg what it lacks");
  EXPECT_EQ(error, ENODEV);
  none.kernel.is_sensor_there = true;
  EXPECT_NO_THROW(none.device().open()) << "found anew at each opening";
  Board forbidden = ov9281();
  forbidden.kernel.open_errors["media0"] = EACCES;
  EXPECT_NE(forbidden.refusal(&error).find("/media0: permission missing"), std::string::npos);
  EXPECT_EQ(error, EACCES);
}

TEST(MediaSensor, IsFoundInFrontOfANodeThatLeavesFormatsToTheGraph) {
  Board board = ov9281(100);
  board.request.device = board.kernel.folders.devices + "/video0";
  board.request.exposure = 2ms;
  board.opened();
  EXPECT_EQ(board.kernel.values[V4L2_CID_EXPOSURE], 261);
  board.device().close();
  // Of two, the one that is connected.
  board.kernel.has_second = true;
  EXPECT_NO_THROW(board.device().open());
  board.device().close();
  board.kernel.sensor_link = 0;
  EXPECT_NE(
      board.refusal().find("/video0: several sensors can be in front of it: write one of 'sensor:ov9281 10-0060', "
                           "'sensor:ov9281 11-0060'"),
      std::string::npos);
  // A node that decides its formats itself is no business of the graph's.
  Board own = ov9281();
  own.request.device = own.kernel.folders.devices + "/video0";
  own.kernel.video.capabilities &= ~std::uint32_t{V4L2_CAP_IO_MC};
  own.kernel.video.formats.front().rate_hz = 50;
  own.kernel.at_receiver.code = own.kernel.code;
  own.kernel.at_receiver.width = 1280, own.kernel.at_receiver.height = 800;
  own.opened();
  EXPECT_EQ(own.kernel.done, Lines{});
}

TEST(MediaSensor, WhatTheChainRefusesIsSaidWithItsPart) {
  const auto refusal = [](const std::function<void(Board&)>& change) {
    Board board = ov9281();
    change(board);
    return board.refusal().substr(std::string("sensor:ov9281: ").size());
  };
  EXPECT_EQ(refusal([](Board& b) { b.kernel.refusals[VIDIOC_SUBDEV_S_FMT] = EINVAL; }),
            "'ov9281 10-0060' refused GREY 1280x800: Invalid argument");
  EXPECT_EQ(refusal([](Board& b) { b.kernel.refusals[VIDIOC_SUBDEV_S_FMT] = EBUSY; }),
            "'ov9281 10-0060' is busy: stop the program that uses the camera");
  EXPECT_EQ(refusal([](Board& b) {
              b.kernel.change_format = [](v4l2_mbus_framefmt& format, int fd) {
                if (fd == FakeMediaKernel::kReceiverFd) format.width = 1264;
              };
            }),
            "asked for GREY 1280x800, 'unicam' makes GREY 1264x800 of it");
  EXPECT_EQ(refusal([](Board& b) { b.request.pixel_format = "RGGB10"; }),
            "the camera has no RGGB10 1280x800; it offers GREY, Y10P, Y10 1280x800, 1280x720, 640x400");
  EXPECT_NE(refusal([](Board& b) {
              b.kernel.video.refusals[VIDIOC_STREAMON] = EPIPE;
            }).find("starting the stream: the formats along ov9281 10-0060 -> unicam -> "),
            std::string::npos);
  EXPECT_EQ(refusal([](Board& b) {
              b.kernel.sensor.pixel_rate.clear();
              b.request.exposure = 1ms;
            }),
            "the sensor does not tell its line time, in which its exposure counts; remove camera.exposure_us");
  EXPECT_EQ(refusal([](Board& b) {
              b.kernel.change_format = [&b](v4l2_mbus_framefmt&, int) { b.kernel.controls.erase(V4L2_CID_EXPOSURE); };
              b.kernel.sensor.pixel_rate.clear();
              b.request.exposure = 1ms;
            }).find("remove camera.exposure_us") != std::string::npos,
            true);
}

TEST(MediaSensor, IsLeftAloneWhileAnotherProgramHasItsPictures) {
  for (const unsigned long claim : {VIDIOC_S_FMT, VIDIOC_REQBUFS}) {
    Board board = ov9281(100);
    board.request.exposure = 2ms;
    board.kernel.sensor_link = 0;
    board.kernel.video.refusals[claim] = EBUSY;
    int error = 0;
    EXPECT_NE(board.refusal(&error).find("/video0: busy: stop the program that uses it"), std::string::npos);
    EXPECT_EQ(error, EBUSY);
    EXPECT_EQ(board.kernel.done, Lines{}) << "`ninedot check` beside a running service must not change its camera";
  }
}

TEST(MediaSensor, TellsItsLineTimeAndWhatSpeaksAgainstTheRowTime) {
  const auto said = [](FakeSensor sensor, std::chrono::nanoseconds row_time) {
    Board board(std::move(sensor), 1280, 800, 72);
    board.request.device = "sensor:";
    board.request.expected_row_time = row_time;
    const std::string text = board.opened().description();
    return text.substr(text.find("/video0, ") + 9);
  };
  FakeSensor rolling = fake_ov9281();
  rolling.name = "ov5647 10-0036";
  EXPECT_EQ(said(fake_ov9281(), 0us), "global shutter, line time 7.65 us");
  EXPECT_EQ(said(fake_ov9281(), 8us),
            "line time 7.65 us, but this shutter is global: camera.row_time_us should be 0, not 8");
  EXPECT_EQ(said(rolling, 0us), "line time 7.65 us (camera.row_time_us = 7.65 if its shutter rolls)");
  EXPECT_EQ(said(rolling, 7700ns), "line time 7.65 us");
  EXPECT_EQ(said(rolling, 8us), "line time 7.65 us, but camera.row_time_us = 8");
}

TEST(MediaGraph, ThatGrowsWhileItIsReadIsReadAgain) {
  FakeMediaKernel kernel(fake_ov9281());
  kernel.grows = 2;
  const MediaGraphs read = read_media_graphs(kernel, kernel.folders);
  ASSERT_EQ(read.graphs.size(), 1U);
  EXPECT_EQ(read.graphs[0].entities.size(), 4U);
  EXPECT_EQ(read.graphs[0].origin, "unicam, platform:fe801000.csi");
  kernel.grows = 100;
  EXPECT_EQ(read_media_graphs(kernel, kernel.folders).graphs.size(), 0U);
}

TEST(MediaList, ShowsASensorWithItsWaySizesRatesAndTheNodeOnlyOnce) {
  FakeMediaKernel kernel(fake_ov9281());
  std::vector<CameraListing> cameras = list_v4l2_cameras(kernel, kernel.folders);
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0].device, "sensor:ov9281 10-0060");
  EXPECT_EQ(cameras[0].name, "unicam, platform:fe801000.csi");
  EXPECT_EQ(cameras[0].path, "ov9281 10-0060 -> unicam -> " + kernel.folders.devices + "/video0");
  EXPECT_EQ(cameras[0].now, "Y10 1280x800, 2 to 114.9 Hz, line time 9.563 us");
  EXPECT_EQ(cameras[0].formats, Lines{"GREY, Y10P, Y10 1280x800, 1280x720, 640x400"});
  EXPECT_EQ(cameras[0].identity, "unicam@platform:fe801000.csi");
  EXPECT_EQ(cameras[0].controls.size(), 4U);
  EXPECT_EQ(kernel.done, Lines{}) << "nothing is set";
  EXPECT_EQ(kernel.open_nodes, 0);

  FakeMediaKernel cutting(fake_imx296());
  EXPECT_EQ(list_v4l2_cameras(cutting, cutting.folders).at(0).now,
            "Y10 1456x1088, 0.0644 to 60.38 Hz, line time 14.81 us, cuts smaller sizes out of 1456x1088");
  kernel.video.open_error = EBUSY;
  EXPECT_NE(list_v4l2_cameras(kernel, kernel.folders).at(0).problem.find("busy"), std::string::npos);
}

}  // namespace
}  // namespace ninedot
