#include "programs/service/service_log.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <functional>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

std::string written(const std::function<void()>& work) {
  testing::internal::CaptureStderr();
  work();
  return testing::internal::GetCapturedStderr();
}

Report report_of(Reason reason) {
  Report report;
  report.reason = reason;
  report.landmark_id = 7;
  report.distance_m = 2;
  return report;
}

constexpr MonoTime at(std::chrono::nanoseconds since) { return MonoTime(1000s) + since; }

TEST(ServiceLog, TellsOfTheFirstReportAtOnceAndOfAChangeWhenItHasLasted) {
  ServiceLog log;
  const auto note = [&](Reason reason, std::chrono::nanoseconds since) {
    return written([&] { log.note(report_of(reason), {}, at(since)); });
  };
  EXPECT_EQ(note(Reason::kStarting, 0s), "");
  EXPECT_EQ(note(Reason::kNone, 1s), "ninedotd: landmark 7 found at 2.000 m\n");
  EXPECT_EQ(note(Reason::kNoLandmark, 2s), "");
  EXPECT_EQ(note(Reason::kNoLandmark, 2400ms), "");
  EXPECT_EQ(note(Reason::kNone, 2500ms), "") << "it was hidden for a moment";
  EXPECT_EQ(note(Reason::kNoLandmark, 3s), "");
  EXPECT_EQ(note(Reason::kNoLandmark, 3500ms), "ninedotd: the frame shows no landmark\n");
  EXPECT_EQ(note(Reason::kNoLandmark, 9s), "") << "told already";
}

TEST(ServiceLog, TellsTheSourcesErrorWhereTheSourceFailedAndOnlyThere) {
  const auto first_line = [](Reason reason, const Error& last_error) {
    ServiceLog log;
    return written([&] { log.note(report_of(reason), last_error, at(0s)); });
  };
  EXPECT_EQ(first_line(Reason::kCameraLost, {Errc::kCameraLost, ENODEV, "its cable is out"}),
            "ninedotd: the camera vanished or stalled: its cable is out (No such device)\n");
  EXPECT_EQ(first_line(Reason::kFrameUnreadable, {Errc::kFrameUnreadable, 0, "cut off"}),
            "ninedotd: the picture could not be read: cut off\n");
  EXPECT_EQ(first_line(Reason::kFrameSize, {Errc::kFrameSize, 0, "too small"}),
            "ninedotd: the frame's size is not the calibration's: too small\n");
  EXPECT_EQ(first_line(Reason::kCameraLost, {}), "ninedotd: the camera vanished or stalled\n");
  for (const Reason reason : {Reason::kNoLandmark, Reason::kPoseDegenerate, Reason::kStopped})
    EXPECT_EQ(first_line(reason, {Errc::kCameraLost, ENODEV, "long ago"}),
              fmt::format("ninedotd: {}\n", reason_sentence(reason)));
}

TEST(ServiceLog, TellsOnceOfACameraThatIsAbsentAtTheStart) {
  ServiceLog log;
  EXPECT_EQ(written([&] { log.note_camera_absent("/dev/video9: no such camera"); }),
            "ninedotd: camera: waits for it: /dev/video9: no such camera\n");
  const auto note = [&](Reason reason, std::chrono::nanoseconds since) {
    return written([&] { log.note(report_of(reason), {Errc::kCameraLost, ENOENT, "not open"}, at(since)); });
  };
  EXPECT_EQ(note(Reason::kStarting, 0s), "");
  EXPECT_EQ(note(Reason::kCameraLost, 10ms), "");
  EXPECT_EQ(note(Reason::kCameraLost, 5s), "");
  EXPECT_EQ(note(Reason::kNone, 6s), "");
  EXPECT_EQ(note(Reason::kNone, 7s), "ninedotd: landmark 7 found at 2.000 m\n");
}

TEST(ServiceLog, TellsOfADeviceOnceWhenItGoesAndOnceWhenItIsBack) {
  ServiceLog log;
  const auto note = [&](const char* problem, std::chrono::nanoseconds since) {
    return written([&] { log.note_device("inhibit input", problem, "", at(since)); });
  };
  EXPECT_EQ(note("", 0s), "") << "nothing to say about what works";
  EXPECT_EQ(note("gone", 1s), "") << "it may be a loose contact";
  EXPECT_EQ(note("no chip", 2s), "ninedotd: inhibit input: gone, waits for it: no chip\n");
  EXPECT_EQ(note("still none", 3s), "") << "told already";
  EXPECT_EQ(note("", 4s), "");
  EXPECT_EQ(note("", 5s), "ninedotd: inhibit input: there\n");
  EXPECT_EQ(note("", 6s), "");
}

TEST(ServiceLog, TellsOnceWhatElseKeepsADeviceAwayWhenItHasLasted) {
  ServiceLog log;
  const auto note = [&](const char* problem, std::chrono::nanoseconds since) {
    return written([&] { log.note_device("head", problem, "", at(since)); });
  };
  EXPECT_EQ(note("no chip", 0s), "ninedotd: head: not there, waits for it: no chip\n");
  EXPECT_EQ(note("no chip", 60s), "");
  EXPECT_EQ(note("not permitted", 61s), "");
  EXPECT_EQ(note("not permitted", 75s), "");
  EXPECT_EQ(note("not permitted", 77s), "ninedotd: head: still waits for it: not permitted\n");
  EXPECT_EQ(note("not permitted", 300s), "");
  std::string lines;
  for (int second = 300; second < 900; ++second) lines += note(second / 5 % 2 == 0 ? "busy" : "no chip", second * 1s);
  EXPECT_EQ(lines, "") << "one that fails in turns in two ways";
}

TEST(ServiceLog, TellsOnceWhatElseKeepsTheCameraAwayWhenItHasLasted) {
  ServiceLog log;
  const auto note = [&](int error, std::chrono::nanoseconds since) {
    return written([&] {
      log.note(report_of(Reason::kCameraLost), {Errc::kCameraLost, error, "not open"}, at(since));
    });
  };
  EXPECT_EQ(written([&] { log.note_camera_absent("/dev/video9: no such camera"); }),
            "ninedotd: camera: waits for it: /dev/video9: no such camera\n");
  EXPECT_EQ(note(ENOENT, 0s), "");
  EXPECT_EQ(note(ENOENT, 60s), "");
  EXPECT_EQ(note(EPERM, 61s), "");
  EXPECT_EQ(note(EPERM, 77s), "ninedotd: " + std::string(reason_sentence(Reason::kCameraLost)) +
                                  ": not open (Operation not permitted)\n");
  EXPECT_EQ(note(EPERM, 600s), "");
}

TEST(ServiceLog, TellsAtOnceWhatIsMissingAtTheStartAndWhatThereIsToSay) {
  ServiceLog log;
  EXPECT_EQ(written([&] { log.note_device("LED", "no chip", "", at(0s)); }),
            "ninedotd: LED: not there, waits for it: no chip\n");
  EXPECT_EQ(written([&] { log.note_device("head", "", "visca, zoom 3", at(0s)); }), "ninedotd: head: visca, zoom 3\n");
}

TEST(ServiceLog, StaysSilentAboutADeviceThatFlickers) {
  ServiceLog log;
  EXPECT_EQ(written([&] {
              for (int i = 0; i < 1000; ++i) log.note_device("line", i % 2 == 0 ? "" : "gone", "", at(i * 100ms));
            }),
            "");
}

TEST(ServiceLog, TellsTheFirstOfASeriesAtOnceAndTheRestOnceAMinute) {
  ServiceLog log;
  std::string lines;
  std::uint64_t count = 0;
  for (int second = 0; second < 150; ++second) {
    count += second >= 10 && second < 130 ? 100 : 0;
    lines += written([&] { log.note_series("frames", count, "", at(second * 1s)); });
  }
  EXPECT_EQ(lines,
            "ninedotd: 100 frames\n"
            "ninedotd: 6000 more frames since\n"
            "ninedotd: 5900 more frames since\n");
}

TEST(ServiceLog, NamesTheNewestOfASeries) {
  ServiceLog log;
  EXPECT_EQ(written([&] { log.note_series("clients refused", 1, "10.0.0.9 is not allowed", at(0s)); }),
            "ninedotd: 1 clients refused: 10.0.0.9 is not allowed\n");
  EXPECT_EQ(written([&] { log.note_series("clients refused", 8, "10.0.0.7 is not allowed", at(61s)); }),
            "ninedotd: 7 more clients refused since: the last one 10.0.0.7 is not allowed\n");
}

TEST(ServiceLog, TellsWhichLandmarksSomebodyHasToMeasureOnceThatLasts) {
  ServiceLog log;
  const auto note = [&](const Report& report, std::chrono::milliseconds from, std::chrono::milliseconds until) {
    return written([&] {
      for (auto when = from; when <= until; when += 100ms) log.note_misplaced(report, at(when));
    });
  };
  Report report;
  EXPECT_EQ(note(report, 0s, 1s), "");
  report.landmarks_rejected = 1, report.last_rejected_id = 12;
  EXPECT_EQ(note(report, 1s, 1100ms), "") << "chance";
  EXPECT_EQ(note(report, 2s, 2400ms), "") << "once more";
  EXPECT_EQ(note(report, 5s, 9s),
            "ninedotd: landmark 12 does not hang where the map says: poses are made without it; measure its place\n");
  EXPECT_EQ(note({}, 9s, 10s), "") << "it is out of view";
  EXPECT_EQ(note(report, 3000s, 3002s), "");
  EXPECT_EQ(note(report, 6000s, 6002s), "") << "less than an hour ago it was so";
  EXPECT_NE(note(report, 9603s, 9604s), "");
  report = {};
  report.landmarks_disputed = 2, report.disputed_ids = {1, 2};
  EXPECT_EQ(note(report, 9610s, 9612s),
            "ninedotd: landmarks 1 and 2 contradict each other: one of them does not hang where the map says; measure "
            "both\n");
  report.disputed_ids = {1, 3};
  EXPECT_NE(note(report, 9613s, 9614s), "") << "another pair";
  report.landmarks_disputed = 1, report.disputed_ids = {3, 65535};
  EXPECT_EQ(note(report, 9615s, 9617s), "") << "what is left of a pair is no news";
}

TEST(ServiceLog, TellsOnceWhatLandmarksShowOfTheShutter) {
  ServiceLog log;
  const auto note = [&](const RowTime& rows) { return written([&] { log.note_row_time(rows); }); };
  EXPECT_EQ(note({0, 33e-6, RowTimeSource::kOpen}), "");
  EXPECT_TRUE(note({33e-6, 1e-6, RowTimeSource::kSeen}).starts_with("ninedotd: shutter: 33.0 us from row to row"));
  EXPECT_EQ(note({33.1e-6, 0.9e-6, RowTimeSource::kSeen}), "") << "told already";
}

TEST(ServiceLog, CutsALineThatHasNoEnd) {
  ServiceLog log;
  EXPECT_EQ(written([&] { log.write(std::string(1000, 'x')); }), "ninedotd: " + std::string(1000, 'x') + "\n");
  EXPECT_EQ(written([&] { log.write(std::string(1'000'000, 'x')); }), "ninedotd: " + std::string(997, 'x') + "...\n");
  std::string letters;
  while (letters.size() < 2000) letters += "\u00e4";
  EXPECT_EQ(written([&] { log.write(letters); }), "ninedotd: " + letters.substr(0, 996) + "...\n") << "no half letter";
}

TEST(ServiceLog, ALineBreakInAPathMakesNoSecondLine) {
  ServiceLog log;
  EXPECT_EQ(written([&] { log.write("map a\nb read again"); }), "ninedotd: map a?b read again\n");
}

}  // namespace
}  // namespace ninedot
