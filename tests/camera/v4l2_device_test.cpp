#include "drivers/camera/v4l2_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "drivers/camera/v4l2_controls.h"
#include "drivers/camera/v4l2_formats.h"
#include "drivers/camera/v4l2_list.h"
#include "fake_video_kernel.h"
#include "tests/support/allocation_counter.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr int kWidth = 32, kHeight = 4;
constexpr std::uint32_t kMono = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;

struct Bench {
  explicit Bench(std::uint32_t fourcc = V4L2_PIX_FMT_GREY) {
    kernel.formats = {{fourcc, {{kWidth, kHeight}}, 50}};
    request.device = "/dev/video-of-the-test";
    request.width_px = kWidth;
    request.height_px = kHeight;
    request.rate_hz = 50;
  }
  V4l2Device& device() {
    if (!device_) device_.emplace(request, kernel);
    return *device_;
  }
  V4l2Device& opened() {
    device().open();
    return device();
  }
  std::string refusal() {
    try {
      device().open();
    } catch (const CameraRefused& refused) {
      EXPECT_EQ(refused.status, ExitStatus::kWrongUsage);
      EXPECT_FALSE(kernel.is_open) << "a refused camera is closed again";
      EXPECT_EQ(kernel.mapped, 0);
      const std::string line = refused.what();
      EXPECT_EQ(line.find('\n'), std::string::npos);
      const std::string start = request.device + ": ";
      EXPECT_EQ(line.substr(0, start.size()), start);
      return line.substr(std::min(line.size(), start.size()));
    }
    return "no refusal";
  }

  FakeVideoKernel kernel;
  CameraRequest request;

 private:
  std::optional<V4l2Device> device_;
};

TEST(V4l2Device, LendsTheDriversOwnBufferOfLumaAndTakesItBack) {
  Bench bench;
  bench.kernel.stride_bytes = 64;
  V4l2Device& device = bench.opened();
  EXPECT_EQ(bench.kernel.queued.size(), 4U);
  bench.kernel.deliver({.sequence = 9, .stamp = mono_now()}, 77);
  const Result<GrabbedFrame> frame = device.grab(mono_now() + 1s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.luma.pixels, bench.kernel.memory[frame->buffer].data()) << "no copy";
  EXPECT_EQ(frame->frame.luma.stride_bytes, 64);
  EXPECT_EQ(frame->frame.luma.at(31, 3), 77);
  EXPECT_EQ(frame->sequence, 9U);
  EXPECT_EQ(bench.kernel.queued.size(), 3U);
  device.release(frame->buffer);
  EXPECT_EQ(bench.kernel.queued.size(), 4U);
  device.close();
  EXPECT_FALSE(bench.kernel.is_open);
  EXPECT_EQ(bench.kernel.mapped, 0);
}

TEST(V4l2Device, LeavesTheColourReadableBesideTheLuma) {
  for (const char* const name : {"NV12", "YU12", "YUYV"}) {
    Bench bench(find_pixel_format(name)->fourcc);
    V4l2Device& device = bench.opened();
    bench.kernel.deliver({.stamp = mono_now()}, 90);
    const Result<GrabbedFrame> frame = device.grab(mono_now() + 1s);
    ASSERT_TRUE(frame) << name;
    ASSERT_FALSE(frame->frame.chroma.empty()) << name;
    const std::vector<std::uint8_t>& memory = bench.kernel.memory[frame->buffer];
    EXPECT_EQ(frame->frame.chroma.cr_at(frame->frame.chroma.width - 1, frame->frame.chroma.height - 1), 90) << name;
    EXPECT_LT(&frame->frame.chroma.cr[frame->frame.chroma.stride_bytes * (frame->frame.chroma.height - 1)],
              memory.data() + memory.size());
  }
  Bench grey;
  V4l2Device& device = grey.opened();
  grey.kernel.deliver({.stamp = mono_now()});
  EXPECT_TRUE(device.grab(mono_now() + 1s)->frame.chroma.empty());
}

TEST(V4l2Device, ConvertsOtherFormatsIntoItsOwnMemory) {
  for (const char* const name : {"YUYV", "UYVY", "Y10", "Y12", "Y16", "Y10P", "Y12P"}) {
    Bench bench(find_pixel_format(name)->fourcc);
    V4l2Device& device = bench.opened();
    bench.kernel.deliver({.stamp = mono_now()}, name == std::string("Y10") || name == std::string("Y12") ? 1 : 90);
    const Result<GrabbedFrame> frame = device.grab(mono_now() + 1s);
    ASSERT_TRUE(frame) << name;
    EXPECT_NE(frame->frame.luma.pixels, bench.kernel.memory[frame->buffer].data());
    EXPECT_EQ(frame->frame.luma.stride_bytes, kWidth);
    const int expected = name == std::string("Y10") ? 0x0101 >> 2 : name == std::string("Y12") ? 0x0101 >> 4 : 90;
    EXPECT_EQ(frame->frame.luma.at(31, 3), expected) << name;
  }
}

TEST(V4l2Device, DevelopsASensorsMosaicIntoLumaAndColour) {
  Bench bench(V4L2_PIX_FMT_SRGGB10);
  bench.request.bayer = {64, 1, 1};
  V4l2Device& device = bench.opened();
  bench.kernel.deliver({.stamp = mono_now()}, 1);  // 0x0101: 257
  const Result<GrabbedFrame> frame = device.grab(mono_now() + 1s);
  ASSERT_TRUE(frame);
  const double level = 255 * std::sqrt((257 - 64) / (1023.0 - 64));
  EXPECT_NEAR(frame->frame.luma.at(31, 3), level, 0.6);
  ASSERT_FALSE(frame->frame.chroma.empty());
  EXPECT_EQ(frame->frame.chroma.cb_at(15, 1), 128) << "all alike: no colour";
}

TEST(V4l2Device, RefusesABlackLevelThatLeavesNoLight) {
  Bench bench(V4L2_PIX_FMT_SRGGB8);
  bench.request.bayer.black_level = 256;  // of a sensor of 12 bits
  try {
    bench.opened();
    FAIL() << "no refusal";
  } catch (const CameraRefused& refused) {
    EXPECT_NE(std::string(refused.what()).find("camera.black_level = 256 leaves no light: RGGB goes to 255"),
              std::string::npos)
        << refused.what();
  }
}

TEST(V4l2Device, TheNewestFrameWinsAndTheOlderOnesAreGivenBackAndCounted) {
  Bench bench;
  V4l2Device& device = bench.opened();
  for (std::uint32_t i = 0; i < 3; ++i)
    bench.kernel.deliver({.sequence = i, .stamp = mono_now()}, static_cast<std::uint8_t>(10 + i));
  const Result<GrabbedFrame> frame = device.grab(mono_now());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.luma.at(0, 0), 12);
  EXPECT_EQ(frame->skipped, 2U);
  EXPECT_EQ(bench.kernel.queued.size(), 3U);
}

TEST(V4l2Device, GrabsConvertsAndReleasesWithoutTheHeap) {
  for (const std::uint32_t fourcc :
       {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_Y10, V4L2_PIX_FMT_SRGGB8, V4L2_PIX_FMT_SBGGR10P}) {
    Bench bench(fourcc);
    V4l2Device& device = bench.opened();
    for (std::uint32_t i = 0; i < 20; ++i) {
      bench.kernel.deliver({.sequence = i, .stamp = mono_now()});
      const test::AllocationGuard guard;
      const Result<GrabbedFrame> frame = device.grab(mono_now());
      ASSERT_TRUE(frame);
      device.release(frame->buffer);
      ASSERT_EQ(device.grab(mono_now()).error().code, Errc::kNoFrame);
      EXPECT_EQ(guard.allocations() + guard.releases(), 0U) << fourcc << ", frame " << i;
    }
  }
}

TEST(V4l2Device, BuffersFlaggedOrTooShortAreSkippedAndCounted) {
  Bench bench;
  V4l2Device& device = bench.opened();
  bench.kernel.deliver({.sequence = 0, .stamp = mono_now()}, 50);
  bench.kernel.deliver({.sequence = 1, .stamp = mono_now(), .flags = kMono | V4L2_BUF_FLAG_ERROR}, 51);
  bench.kernel.deliver({.sequence = 2, .stamp = mono_now(), .bytes = kWidth * kHeight - 1}, 52);
  const Result<GrabbedFrame> frame = device.grab(mono_now());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.luma.at(0, 0), 50) << "the newest GOOD frame";
  EXPECT_EQ(frame->flagged, 2U);
  EXPECT_EQ(frame->skipped, 0U);
  EXPECT_EQ(bench.kernel.queued.size(), 3U);
}

TEST(V4l2Device, OnlyDamagedBuffersAreNoFrame) {
  Bench bench;
  V4l2Device& device = bench.opened();
  bench.kernel.deliver({.stamp = mono_now(), .flags = kMono | V4L2_BUF_FLAG_ERROR});
  EXPECT_EQ(device.grab(mono_now() + 5ms).error().code, Errc::kNoFrame);
  bench.kernel.deliver({.sequence = 1, .stamp = mono_now()});
  EXPECT_EQ(device.grab(mono_now() + 5ms)->flagged, 1U) << "told with the next good frame";
}

TEST(V4l2Device, AMonotonicStampBecomesTheMiddleOfTheExposure) {
  Bench bench;
  bench.kernel.add_control(V4L2_CID_EXPOSURE_ABSOLUTE, 1, 1000, 156);
  bench.request.exposure = 4ms;
  bench.request.readout = 6ms;
  V4l2Device& device = bench.opened();
  const MonoTime stamp = std::chrono::floor<std::chrono::microseconds>(mono_now() - 20ms);
  bench.kernel.deliver({.stamp = stamp});
  Result<GrabbedFrame> frame = device.grab(mono_now());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.exposed_at(), stamp - 6ms - 2ms) << "end of frame";
  device.release(frame->buffer);
  bench.kernel.deliver({.stamp = stamp, .flags = kMono | V4L2_BUF_FLAG_TSTAMP_SRC_SOE});
  frame = device.grab(mono_now());
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.exposed_at(), stamp + 2ms) << "start of exposure";
}

TEST(V4l2Device, FollowsAnAutomaticExposureThatChangesWithTheLight) {
  Bench bench;
  bench.kernel.add_control(V4L2_CID_EXPOSURE_AUTO, 0, 3, V4L2_EXPOSURE_MANUAL);
  bench.kernel.add_control(V4L2_CID_EXPOSURE_ABSOLUTE, 1, 5000, 50);
  V4l2Device& device = bench.opened();
  const auto grab_frame = [&](MonoTime stamp) {
    bench.kernel.deliver({.stamp = stamp});
    const Result<GrabbedFrame> frame = device.grab(mono_now() + 1s);
    EXPECT_TRUE(frame);
    device.release(frame->buffer);
    return frame->frame;
  };
  const MonoTime stamp = std::chrono::floor<std::chrono::microseconds>(mono_now()) - 1ms;
  EXPECT_EQ(grab_frame(stamp).exposed_at(), stamp - 2500us);

  bench.kernel.values[V4L2_CID_EXPOSURE_ABSOLUTE] = 200;  // it grew dark
  ASSERT_EQ(device.refresh(), V4l2Device::kRefreshPause);
  const Frame dark = grab_frame(stamp + 1us);
  EXPECT_EQ(dark.exposed_at(), stamp + 1us - 10ms);
  EXPECT_EQ(dark.exposure_end - dark.exposure_begin, 20ms);

  bench.kernel.refusals[VIDIOC_G_CTRL] = EIO;  // a camera that does not answer: what was known holds
  EXPECT_EQ(device.refresh(), V4l2Device::kRefreshPause);
  EXPECT_EQ(grab_frame(stamp + 2us).exposed_at(), stamp + 2us - 10ms);
}

TEST(V4l2Device, AsksNoMoreWhereNothingChangesByItself) {
  Bench plain;
  EXPECT_EQ(plain.opened().refresh(), std::nullopt);
  Bench manual;
  manual.kernel.add_control(V4L2_CID_EXPOSURE_AUTO, 0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY);
  manual.kernel.add_control(V4L2_CID_EXPOSURE_ABSOLUTE, 1, 5000, 50);
  manual.request.exposure = 5ms;
  EXPECT_EQ(manual.opened().refresh(), std::nullopt);
}

TEST(V4l2Device, TellsRowTimeAndZoomOfEachFrameAndNoGainThatItDoesNotKnow) {
  Bench bench;
  bench.request.row_time = 30us;
  bench.kernel.add_control(V4L2_CID_ZOOM_ABSOLUTE, 0, 1000, 120);
  V4l2Device& device = bench.opened();
  bench.kernel.values[V4L2_CID_ZOOM_ABSOLUTE] = 240;
  EXPECT_EQ(device.refresh(), V4l2Device::kRefreshPause);
  bench.kernel.deliver({.stamp = mono_now()});
  const Result<GrabbedFrame> frame = device.grab(mono_now() + 1s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame.row_time, 30us);
  EXPECT_EQ(frame->frame.zoom, 240);
  EXPECT_TRUE(std::isnan(frame->frame.gain));
  EXPECT_TRUE(std::isnan(frame->frame.focus_dioptre));
}

TEST(V4l2Device, AStampOfAnotherClockOrFromTheFutureGivesWayToTheArrival) {
  Bench bench;
  V4l2Device& device = bench.opened();
  const MonoTime before = mono_now();
  for (const auto& [stamp, flags] : {std::pair{before - 20ms, std::uint32_t{V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN}},
                                     std::pair{before + 1h, kMono}, std::pair{before - 1h, kMono}}) {
    bench.kernel.deliver({.stamp = stamp, .flags = flags});
    const Result<GrabbedFrame> frame = device.grab(mono_now());
    ASSERT_TRUE(frame);
    EXPECT_GE(frame->frame.exposed_at(), before);
    EXPECT_LE(frame->frame.exposed_at(), mono_now());
    device.release(frame->buffer);
  }
}

TEST(V4l2Device, FaultsOfTheStreamAskForANewOpening) {
  const auto error_after = [](const std::function<void(FakeVideoKernel&)>& fault) {
    Bench bench;
    V4l2Device& device = bench.opened();
    fault(bench.kernel);
    const Result<GrabbedFrame> frame = device.grab(mono_now() + 5ms);
    EXPECT_FALSE(frame);
    return frame ? Error{Errc::kNoFrame} : frame.error();
  };
  for (const int error : {EIO, ENODEV, EINVAL}) {
    const Error lost = error_after([&](FakeVideoKernel& kernel) { kernel.dqbuf_error = error; });
    EXPECT_EQ(lost.code, Errc::kCameraLost);
    EXPECT_EQ(lost.os_errno, error);
  }
  EXPECT_EQ(error_after([](FakeVideoKernel& kernel) { kernel.events = POLLERR; }).code, Errc::kCameraLost);
  EXPECT_EQ(error_after([](FakeVideoKernel& kernel) { kernel.events = POLLHUP; }).code, Errc::kCameraLost);
  EXPECT_EQ(error_after([](FakeVideoKernel& kernel) { kernel.events = -EBADF; }).os_errno, EBADF);
  EXPECT_EQ(error_after([](FakeVideoKernel& kernel) { kernel.events = POLLPRI; }).text,
            std::string("the signal at the camera's input changed"));
  EXPECT_EQ(error_after([](FakeVideoKernel&) {}).code, Errc::kNoFrame) << "silence alone is no fault of the stream";
}

TEST(V4l2Device, WhatStandsInTheWayIsSaidInOneLine) {
  const auto refusal = [](const std::function<void(Bench&)>& change) {
    Bench bench;
    change(bench);
    return bench.refusal();
  };
  EXPECT_EQ(refusal([](Bench& b) { b.kernel.open_error = ENOENT; }),
            "no such camera: connect it, or choose one that `ninedot cameras` lists");
  EXPECT_EQ(refusal([](Bench& b) { b.kernel.open_error = EACCES; }),
            "permission missing: it belongs to the group 'video': usermod -aG video USER, then log in anew");
  EXPECT_EQ(refusal([](Bench& b) { b.kernel.refusals[VIDIOC_S_FMT] = EBUSY; }),
            "busy: stop the program that uses it (fuser /dev/video-of-the-test names it)");
  EXPECT_EQ(refusal([](Bench& b) { b.kernel.refusals[VIDIOC_QUERYCAP] = ENOTTY; }),
            "is no V4L2 camera; `ninedot cameras` lists those");
  EXPECT_NE(refusal([](Bench& b) { b.kernel.capabilities = V4L2_CAP_META_CAPTURE; }).find("captures no pictures"),
            std::string::npos);
  EXPECT_NE(refusal([](Bench& b) { b.kernel.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE; }).find("\"libcamera\""),
            std::string::npos);
  EXPECT_EQ(refusal([](Bench& b) { b.kernel.capabilities = V4L2_CAP_VIDEO_CAPTURE; }),
            "offers no memory-mapped buffers");
  for (const std::uint32_t unlocked : {std::uint32_t{V4L2_IN_ST_NO_H_LOCK}, std::uint32_t{V4L2_IN_ST_NO_SYNC}})
    EXPECT_NE(refusal([&](Bench& b) { b.kernel.input_status = unlocked; }).find("locked on to"), std::string::npos);
  EXPECT_NE(refusal([](Bench& b) { b.kernel.input_status = V4L2_IN_ST_NO_SIGNAL; }).find("no signal"),
            std::string::npos);
  EXPECT_EQ(refusal([](Bench& b) { b.kernel.given_buffers = 1; }), "the driver gives 1 buffers, at least 2 are needed");
  EXPECT_EQ(refusal([](Bench& b) { b.kernel.refusals[VIDIOC_STREAMON] = ENOSPC; }),
            "starting the stream failed: No space left on device");
  EXPECT_EQ(refusal([](Bench& b) { b.request.width_px = 640; }),
            "the camera has no readable format at 640x4; it offers GREY 32x4 50 Hz");
  EXPECT_EQ(refusal([](Bench& b) { b.request.pixel_format = "YUYV"; }),
            "the camera has no YUYV 32x4; it offers GREY 32x4 50 Hz");
  EXPECT_EQ(refusal([](Bench& b) { b.kernel.change_format = [](v4l2_pix_format& format) { format.width = 16; }; }),
            "asked for GREY 32x4, the camera gives GREY 16x4; it offers GREY 32x4 50 Hz");
  EXPECT_EQ(refusal([](Bench& b) { b.request.exposure = 1ms; }),
            "the camera has no control for the exposure time; remove camera.exposure_us");
  EXPECT_EQ(refusal([](Bench& b) { b.request.gain = 3; }),
            "the camera has no control for the gain; remove camera.gain");
  EXPECT_EQ(refusal([](Bench& b) { b.request.power_line = PowerLine::k50Hz; }),
            "the camera has no control for the power-line frequency; remove camera.power_line");
}

TEST(V4l2Device, AJpegThatIsDamagedIsAnUnreadableFrameAndItsBufferGoesBack) {
  Bench bench(V4L2_PIX_FMT_MJPEG);
  V4l2Device& device = bench.opened();
  bench.kernel.deliver({.stamp = mono_now()});
  EXPECT_EQ(device.grab(mono_now()).error().code, Errc::kFrameUnreadable);
  EXPECT_EQ(bench.kernel.queued.size(), 4U);
}

TEST(V4l2Device, AJpegIsDecodedIntoItsOwnMemory) {
  std::ifstream stream(std::string(NINEDOT_SOURCE_DIR) + "/tests/fuzz/corpus/picture/grey.jpg", std::ios::binary);
  const std::vector<char> file(std::istreambuf_iterator<char>(stream), {});
  const std::vector<std::uint8_t> bytes(file.begin(), file.end());
  ASSERT_FALSE(bytes.empty());
  ASSERT_LE(bytes.size(), 4096U);
  const Result<PictureSize> size = read_picture_size(bytes);
  ASSERT_TRUE(size);
  std::vector<std::uint8_t> expected(size->pixel_count());
  ASSERT_TRUE(PictureDecoder(*size).decode(bytes, expected));

  Bench bench(V4L2_PIX_FMT_MJPEG);
  bench.kernel.formats = {{V4L2_PIX_FMT_MJPEG, {{size->width_px, size->height_px}}, 50}};
  bench.request.width_px = size->width_px;
  bench.request.height_px = size->height_px;
  V4l2Device& device = bench.opened();
  bench.kernel.deliver({.stamp = mono_now(), .bytes = static_cast<std::uint32_t>(bytes.size())});
  std::ranges::copy(bytes, bench.kernel.memory[bench.kernel.filled.front().index].begin());
  const Result<GrabbedFrame> frame = device.grab(mono_now());
  ASSERT_TRUE(frame);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), frame->frame.luma.pixels));
}

TEST(V4l2Controls, AutomaticsAreSwitchedOffBeforeTheValuesAreWrittenAndSoAtEachOpening) {
  Bench bench;
  bench.kernel.add_control(V4L2_CID_EXPOSURE_AUTO, 0, 3, 3);
  bench.kernel.add_control(V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0, 1, 1);
  bench.kernel.add_control(V4L2_CID_EXPOSURE_ABSOLUTE, 1, 5000, 156);
  bench.kernel.add_control(V4L2_CID_AUTOGAIN, 0, 1, 1);
  bench.kernel.add_control(V4L2_CID_GAIN, 0, 100, 0);
  bench.kernel.add_control(V4L2_CID_POWER_LINE_FREQUENCY, 0, 2, 0);
  bench.request.exposure = 5ms;
  bench.request.gain = 16;
  bench.request.power_line = PowerLine::k50Hz;
  const std::vector<std::pair<std::uint32_t, int>> expected{
      {V4L2_CID_POWER_LINE_FREQUENCY, V4L2_CID_POWER_LINE_FREQUENCY_50HZ},
      {V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0},
      {V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL},
      {V4L2_CID_EXPOSURE_ABSOLUTE, 50},
      {V4L2_CID_AUTOGAIN, 0},
      {V4L2_CID_GAIN, 16}};
  V4l2Device& device = bench.opened();
  EXPECT_EQ(bench.kernel.written, expected);
  EXPECT_EQ(device.description(), "GREY 32x4, 50 Hz, flicker 50 Hz, exposure 5000 us, gain 16");
  device.close();
  bench.kernel.written.clear();
  device.open();
  EXPECT_EQ(bench.kernel.written, expected) << "a camera that was plugged in anew has forgotten";
}

TEST(V4l2Controls, WhatTheDriverMadeOfAValueIsWhatCounts) {
  Bench bench;
  bench.kernel.add_control(V4L2_CID_EXPOSURE_ABSOLUTE, 1, 5000, 156);
  bench.kernel.round_control = [](int value) { return value / 8 * 8; };
  bench.request.exposure = 5ms;
  const AppliedControls applied = apply_controls(bench.kernel, FakeVideoKernel::kFd, bench.request);
  EXPECT_EQ(applied.now.exposure, 4800us);
  EXPECT_EQ(applied.description, "exposure 4800 us (asked 5000)");
}

TEST(V4l2Controls, AutomaticExposureIsAperturePriorityWhereThereIsNoOther) {
  Bench bench;
  bench.kernel.add_control(V4L2_CID_EXPOSURE_AUTO, 0, 3, 1);
  apply_controls(bench.kernel, FakeVideoKernel::kFd, bench.request);
  EXPECT_EQ(bench.kernel.values[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(describe_controls(bench.kernel, FakeVideoKernel::kFd),
            std::vector<std::string>{"A control: 0 to 3 step 1, now 3"});
}

std::string chosen(std::vector<FakeVideoKernel::Format> formats, double rate_hz, const std::string& wanted = "auto") {
  FakeVideoKernel kernel;
  kernel.formats = std::move(formats);
  CameraRequest request;
  request.rate_hz = rate_hz;
  request.pixel_format = wanted;
  const std::vector<OfferedFormat> offers = read_offered_formats(kernel, FakeVideoKernel::kFd);
  const OfferedFormat* const offer = choose_format(offers, request);
  return offer == nullptr ? "none" : std::string(offer->known->name);
}

TEST(V4l2Formats, ThePreferredFormatThatReachesTheRateIsChosenAndJpegOnlyWhereNothingElseFits) {
  const FakeVideoKernel::Format grey{V4L2_PIX_FMT_GREY, {{640, 480}}, 15}, yuyv{V4L2_PIX_FMT_YUYV, {{640, 480}}, 30},
      jpeg{V4L2_PIX_FMT_MJPEG, {{640, 480}}, 120}, large{V4L2_PIX_FMT_GREY, {{1280, 960}}, 60},
      unknown{V4L2_PIX_FMT_H264, {{640, 480}}, 60};
  EXPECT_EQ(chosen({jpeg, yuyv, grey}, 15), "GREY");
  EXPECT_EQ(chosen({jpeg, yuyv, grey}, 30), "YUYV");
  EXPECT_EQ(chosen({jpeg, yuyv, grey}, 60), "YUYV") << "the fastest without JPEG";
  EXPECT_EQ(chosen({jpeg, large}, 30), "MJPG");
  EXPECT_EQ(chosen({jpeg, yuyv}, 60, "MJPG"), "MJPG");
  EXPECT_EQ(chosen({unknown, large}, 30), "none");
  EXPECT_EQ(chosen({{V4L2_PIX_FMT_NV12, {}, 0}}, 30), "NV12") << "a driver that lists no sizes may have this one";
}

TEST(V4l2Formats, AreDescribedInGroupsOfTheSameSizes) {
  FakeVideoKernel kernel;
  kernel.formats = {{V4L2_PIX_FMT_GREY, {{640, 480}, {320, 240}}, 60},
                    {V4L2_PIX_FMT_H264, {{640, 480}}, 60},
                    {V4L2_PIX_FMT_NV12, {{640, 480}, {320, 240}}, 60},
                    {V4L2_PIX_FMT_YUYV, {{640, 480}}, 30}};
  EXPECT_EQ(describe_offers(read_offered_formats(kernel, FakeVideoKernel::kFd)),
            (std::vector<std::string>{"GREY, NV12 640x480 60 Hz, 320x240 60 Hz", "YUYV 640x480 30 Hz",
                                      "not readable here: H264"}));
  EXPECT_EQ(describe_offers({}), std::vector<std::string>{"no format at all"});
}

TEST(V4l2List, FindsTheNodesThatCaptureAndSaysWhatIsInTheWay) {
  const std::string folder = testing::TempDir() + "ninedot_dev";
  std::filesystem::create_directories(folder + "/v4l/by-id");
  for (const char* const name : {"/video2", "/video10", "/vbi0", "/video-x"}) std::ofstream(folder + name) << "node";
  std::error_code there;
  std::filesystem::create_symlink("../../video10", folder + "/v4l/by-id/usb-camera", there);
  FakeVideoKernel kernel;
  kernel.formats = {{V4L2_PIX_FMT_GREY, {{640, 480}}, 60}};
  kernel.add_control(V4L2_CID_GAIN, 0, 100, 16);
  std::vector<CameraListing> cameras = list_v4l2_cameras(kernel, {folder, folder});
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras[0].device, folder + "/video2");
  EXPECT_EQ(cameras[1].device, folder + "/video10");
  EXPECT_EQ(cameras[1].steady_device, folder + "/v4l/by-id/usb-camera");
  EXPECT_EQ(cameras[1].formats, std::vector<std::string>{"GREY 640x480 60 Hz"});
  EXPECT_EQ(cameras[1].controls, std::vector<std::string>{"A control: 0 to 100 step 1, now 16"});
  kernel.open_error = EACCES;
  EXPECT_NE(list_v4l2_cameras(kernel, {folder, folder}).at(0).problem.find("permission missing"), std::string::npos);
  kernel.open_error = 0;
  kernel.capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  EXPECT_TRUE(list_v4l2_cameras(kernel, {folder, folder}).empty());
  std::filesystem::remove_all(folder);
}

TEST(V4l2Device, OfAnotherCameraThanTheCalibrationsIsRefused) {
  Bench bench;
  bench.kernel.card = "sensor", bench.kernel.bus_info = "platform:1";
  bench.request.is_calibrated = true;
  bench.request.calibrated_id = "sensor@platform:2";
  EXPECT_EQ(bench.refusal(),
            "this camera is 'sensor@platform:1', but the calibration is of 'sensor@platform:2': connect that one, or "
            "set camera.calibration to a calibration of this one");
  for (const char* const id : {"", "sensor@platform:1"}) {
    Bench same;
    same.kernel.card = "sensor", same.kernel.bus_info = "platform:1";
    same.request.calibrated_id = id;
    EXPECT_NO_THROW(same.opened());
  }
}

TEST(V4l2Device, KeepsTheLensWhereTheConfigurationSaysAlsoWhenItWasUnplugged) {
  Bench bench;
  bench.kernel.add_control(V4L2_CID_FOCUS_AUTO, 0, 1, 1);
  bench.kernel.add_control(V4L2_CID_FOCUS_ABSOLUTE, 0, 250, 68);
  bench.request.is_calibrated = true;
  bench.request.focus = Focus::kFixed;
  bench.request.focus_position = 30;
  V4l2Device& device = bench.opened();
  const std::vector<std::pair<std::uint32_t, int>> in_order{{V4L2_CID_FOCUS_AUTO, 0}, {V4L2_CID_FOCUS_ABSOLUTE, 30}};
  EXPECT_EQ(bench.kernel.written, in_order) << "a position is refused, or forgotten, while the automatic is on";
  EXPECT_NE(device.description().find("focus 30"), std::string::npos) << device.description();
  device.close();
  bench.kernel.values[V4L2_CID_FOCUS_AUTO] = 1, bench.kernel.values[V4L2_CID_FOCUS_ABSOLUTE] = 68;
  device.open();
  EXPECT_EQ(bench.kernel.values[V4L2_CID_FOCUS_AUTO], 0);
  EXPECT_EQ(bench.kernel.values[V4L2_CID_FOCUS_ABSOLUTE], 30);
}

TEST(V4l2Device, WithACalibrationRefusesALensThatFocusesByItself) {
  const auto refusal = [](Focus focus, double position, bool calibrated, int is_on) {
    Bench bench;
    bench.kernel.add_control(V4L2_CID_FOCUS_AUTO, 0, 1, is_on);
    bench.kernel.add_control(V4L2_CID_FOCUS_ABSOLUTE, 0, 250, 68);
    bench.request.focus = focus, bench.request.focus_position = position, bench.request.is_calibrated = calibrated;
    return bench.refusal();
  };
  const std::string on =
      "autofocus is on, and a calibration holds for one focus only: set camera.focus = \"fixed\" and "
      "camera.focus_position, from 0 to 250, that of the calibration";
  EXPECT_EQ(refusal(Focus::kUnchanged, -1, true, 1), on);
  EXPECT_EQ(refusal(Focus::kAutomatic, -1, true, 0), on);
  EXPECT_EQ(refusal(Focus::kUnchanged, -1, true, 0), "no refusal");
  EXPECT_EQ(refusal(Focus::kUnchanged, -1, false, 1), "no refusal");
  EXPECT_EQ(refusal(Focus::kAutomatic, -1, false, 0), "no refusal");
  EXPECT_EQ(refusal(Focus::kFixed, -1, true, 1), "set camera.focus_position, from 0 to 250; it is 68 now");
  EXPECT_EQ(refusal(Focus::kFixed, 251, true, 1), "set camera.focus_position, from 0 to 250; it is 68 now");
  Bench none;
  none.request.is_calibrated = true;
  none.request.focus = Focus::kFixed;
  EXPECT_EQ(none.refusal(), "the camera has no control for the focus; remove camera.focus");
  Bench stubborn;
  stubborn.kernel.add_control(V4L2_CID_FOCUS_AUTO, 0, 1, 1);
  stubborn.kernel.round_control = [](int) { return 1; };
  stubborn.request.focus = Focus::kFixed;
  EXPECT_EQ(stubborn.refusal(), "autofocus stays on although camera.focus is \"fixed\"; use another camera");
}

}  // namespace
}  // namespace ninedot
