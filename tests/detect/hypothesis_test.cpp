#include "detect/hypothesis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

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
};

TEST(Hypothesis, OfAWholeRingHasAllNineDotsAndNothingIsCut) {
  Guesses g;
  add_ring(g.blobs, 300, 200, 60, 8);
  g.sorted.assign(g.blobs);
  guess_from_centre(g.sorted, kSheet, g.list, g.cuts);
  ASSERT_EQ(g.list.size(), 1U);
  EXPECT_EQ(g.list[0].matched, 9);
  guess_from_ring(g.sorted, kSheet, g.list, g.cuts);
  EXPECT_EQ(g.cuts.neighbours, 0U);
  EXPECT_EQ(g.cuts.hypotheses, 0U);
}

TEST(Hypothesis, CountsNeighboursOfACentreThatItHasNoRoomFor) {
  Guesses g;
  add_ring(g.blobs, 300, 200, 150, 31);
  g.sorted.assign(g.blobs);
  guess_from_centre(g.sorted, kSheet, g.list, g.cuts);
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
  guess_from_ring(g.sorted, kSheet, g.list, g.cuts);
  EXPECT_GE(g.cuts.neighbours, 11U - 8U);
}

TEST(Hypothesis, CountsGuessesBeyondTheListAndKeepsThoseWithMoreDots) {
  Guesses g;
  for (int i = 0; i < 100; ++i) add_ring(g.blobs, 25 + 43 * (i % 14), 25 + 43 * (i / 14), 15, i < 50 ? 5 : 8);
  g.sorted.assign(g.blobs);
  guess_from_centre(g.sorted, kSheet, g.list, g.cuts);
  EXPECT_TRUE(g.list.full());
  int whole = 0;
  for (const Hypothesis& h : g.list) whole += h.matched == 9 ? 1 : 0;
  EXPECT_EQ(whole, 50);
  EXPECT_GE(g.cuts.hypotheses, 100U - kMaxHypotheses);
}

}  // namespace
}  // namespace ninedot
