#include "programs/web/viewers.h"

#include <gtest/gtest.h>

#include <string>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

std::string viewer(std::size_t number) { return "viewer" + std::to_string(100 + number); }

TEST(WebViewers, AreSixteenAndNoMore) {
  Viewers viewers;
  const MonoTime now{10s};
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NE(viewers.seat_of(viewer(i), now), nullptr);
  EXPECT_EQ(viewers.seat_of(viewer(16), now), nullptr);
  EXPECT_NE(viewers.seat_of(viewer(3), now), nullptr) << "who has a seat keeps it";
  EXPECT_EQ(viewers.count(now), 16U);
}

TEST(WebViewers, LeaveWhenTheyAskNoMore) {
  Viewers viewers;
  for (std::size_t i = 0; i < 16; ++i) viewers.seat_of(viewer(i), MonoTime{10s});
  viewers.seat_of(viewer(5), MonoTime{14s});
  EXPECT_EQ(viewers.count(MonoTime{15s}), 1U);
  EXPECT_NE(viewers.seat_of(viewer(16), MonoTime{15s}), nullptr);
}

TEST(WebViewers, StartAnewWithTheNewestMessage) {
  Viewers viewers;
  viewers.seat_of(viewer(0), MonoTime{10s})->served = 70;
  EXPECT_EQ(viewers.seat_of(viewer(0), MonoTime{11s})->served, 70U);
  EXPECT_EQ(viewers.seat_of(viewer(0), MonoTime{20s})->served, 0U);
}

TEST(WebViewers, WantEveryFrameForAsLongAsOneOfThemDoes) {
  Viewers viewers;
  EXPECT_FALSE(viewers.want_every(MonoTime{10s}));
  viewers.seat_of(viewer(0), MonoTime{10s});
  viewers.seat_of(viewer(1), MonoTime{10s})->wants_every = true;
  viewers.seat_of(viewer(0), MonoTime{14s});
  EXPECT_TRUE(viewers.want_every(MonoTime{14s}));
  EXPECT_FALSE(viewers.want_every(MonoTime{15s})) << "the one that did has left";
  EXPECT_FALSE(viewers.seat_of(viewer(1), MonoTime{16s})->wants_every) << "who comes back says it anew";
}

TEST(WebViewers, HavePlainNames) {
  EXPECT_TRUE(Viewers::is_name("0123abcdXYZ"));
  for (const char* name : {"", "short", "with space", "quote\"quote", "0123456789012345678901234567890123",
                           "\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4"})
    EXPECT_FALSE(Viewers::is_name(name)) << name;
}

}  // namespace
}  // namespace ninedot
