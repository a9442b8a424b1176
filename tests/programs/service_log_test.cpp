#include "programs/service/service_log.h"

#include <gtest/gtest.h>

#include <functional>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

std::string written(const std::function<void()>& work) {
  testing::internal::CaptureStderr();
  work();
  return testing::internal::GetCapturedStderr();
}

constexpr MonoTime at(std::chrono::nanoseconds since) { return MonoTime(1000s) + since; }

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

}  // namespace
}  // namespace ninedot
