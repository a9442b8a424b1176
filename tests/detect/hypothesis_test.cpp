#include "detect/hypothesis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

namespace ninedot {
namespace {

const LandmarkGeometry kSheet;

void add_disc(BlobList& blobs, double x_px, double y_px, double radius_px) {
  const auto second = static_cast<float>(radius_px * radius_px / 4);
  ASSERT_TRUE(
      blobs.try_push_back(Blob{static_cast<float>(x_px), static_cast<float>(y_px),
                               static_cast<float>(std::numbers::pi * radius_px * radius_px), second, 0, second, 0}));
}

/// P9 alone and `count` dots around it.
void add_ring(BlobList& blobs, double x_px, double y_px, double ring_px, int count) {
  add_disc(blobs, x_px, y_px, ring_px * kSheet.centre_radius_m / kSheet.ring_radius_m);
  for (int i = 0; i < count; ++i) {
    const double a_rad = 2 * std::numbers::pi * i / count;
    add_disc(blobs, x_px + ring_px * std::cos(a_rad), y_px + ring_px * std::sin(a_rad),
             ring_px * kSheet.dot_radius_m / kSheet.ring_radius_m);
  }
}

struct Guesses {
  BlobList blobs;
  SortedBlobs sorted{640, 480};
  HypothesisList list;
  GuessCuts cuts;
  int allowance = 1000000;
  GuessBegin begin;

  bool from_centre() { return guess_from_centre(sorted, kSheet, allowance, begin.centre, list, cuts); }
  bool from_ring() { return guess_from_ring(sorted, kSheet, allowance, begin.middle, list, cuts); }
};

TEST(Hypothesis, OfAWholeRingHasAllNineDotsAndNothingIsCut) {
  Guesses g;
  add_ring(g.blobs, 300, 200, 60, 8);
  g.sorted.assign(g.blobs);
  g.from_centre();
  ASSERT_EQ(g.list.size(), 1U);
  EXPECT_EQ(g.list[0].matched, 9);
  g.from_ring();
  EXPECT_EQ(g.cuts.neighbours, 0U);
  EXPECT_EQ(g.cuts.hypotheses, 0U);
}

TEST(Hypothesis, OfACentreAndEverySecondDotHasAllFive) {
  Guesses g;
  add_ring(g.blobs, 300, 200, 60, 8);
  for (const std::size_t covered : {7U, 5U, 3U, 1U}) g.blobs[covered] = g.blobs[g.blobs.size() - 1], g.blobs.pop_back();
  g.sorted.assign(g.blobs);
  g.from_centre();
  ASSERT_EQ(g.list.size(), 1U);
  EXPECT_EQ(g.list[0].matched, 5);
}

TEST(Hypothesis, CountsNeighboursOfACentreThatItHasNoRoomFor) {
  Guesses g;
  add_ring(g.blobs, 300, 200, 150, 31);
  g.sorted.assign(g.blobs);
  g.from_centre();
  EXPECT_EQ(g.cuts.neighbours, 31U - 24U);
}

TEST(Hypothesis, CountsNeighboursOfARingDotThatItHasNoRoomFor) {
  Guesses g;
  add_disc(g.blobs, 300, 200, 10);
  for (int i = 0; i < 11; ++i) {
    const double a_rad = 2 * std::numbers::pi * i / 11;
    add_disc(g.blobs, 300 + 48 * std::cos(a_rad), 200 + 48 * std::sin(a_rad), 10);
  }
  g.sorted.assign(g.blobs);
  g.from_ring();
  EXPECT_GE(g.cuts.neighbours, 11U - 8U);
}

TEST(Hypothesis, CountsGuessesBeyondTheListAndKeepsThoseWithMoreDots) {
  Guesses g;
  for (int i = 0; i < 100; ++i) add_ring(g.blobs, 25 + 43 * (i % 14), 25 + 43 * (i / 14), 15, i < 50 ? 5 : 8);
  g.sorted.assign(g.blobs);
  g.from_centre();
  EXPECT_TRUE(g.list.full());
  int whole = 0;
  for (const Hypothesis& h : g.list) whole += h.matched == 9 ? 1 : 0;
  EXPECT_EQ(whole, 50);
  EXPECT_GE(g.cuts.hypotheses, 100U - kMaxHypotheses);
}

/// Twenty whole rings, far apart.
void add_twenty_rings(BlobList& blobs) {
  for (int i = 0; i < 20; ++i) add_ring(blobs, 60 + 120 * (i % 5), 60 + 120 * (i / 5), 40, 8);
}

std::set<std::int16_t> centres_of(const HypothesisList& list) {
  std::set<std::int16_t> centres;
  for (const Hypothesis& h : list) centres.insert(h.blob[kCentreDot]);
  return centres;
}

TEST(Hypothesis, FromCentresThatRanOutOfAllowanceGoOnWithTheNextCentre) {
  Guesses g;
  add_twenty_rings(g.blobs);
  g.sorted.assign(g.blobs);
  std::set<std::int16_t> seen;
  for (int picture = 0; picture < 4; ++picture) {
    g.list.clear();
    g.allowance = 6;
    EXPECT_EQ(g.from_centre(), false) << picture;
    EXPECT_EQ(g.allowance, 0);
    EXPECT_EQ(g.list.size(), 6U);
    seen.merge(centres_of(g.list));
  }
  EXPECT_EQ(seen.size(), 20U);
  g.allowance = 20;
  EXPECT_TRUE(g.from_centre());
  EXPECT_EQ(g.begin.centre, 0U);
}

TEST(Hypothesis, FromTheRingGoOnAfterTheDotThatTookAllAllowance) {
  Guesses g;
  add_twenty_rings(g.blobs);
  g.sorted.assign(g.blobs);
  std::set<std::int16_t> seen;
  for (int picture = 0; picture < 40 && seen.size() < 20; ++picture) {
    g.list.clear();
    g.allowance = 2;
    EXPECT_EQ(g.from_ring(), false) << picture;
    seen.merge(centres_of(g.list));
  }
  EXPECT_EQ(seen.size(), 20U);
}

}  // namespace
}  // namespace ninedot
