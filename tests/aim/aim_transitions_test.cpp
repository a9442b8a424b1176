#include "aim/aim_transitions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <tuple>

namespace ninedot {
namespace {

using enum AimState;
using enum AimEvent;

AimEvents of(std::initializer_list<AimEvent> list) {
  AimEvents events;
  for (const AimEvent event : list) events.set(event, true);
  return events;
}

TEST(AimTransitions, AreAllTriedOneByOne) {
  // Written down a second time, from what the head is there for.
  const std::set<std::tuple<AimState, AimEvent, AimState>> expected{
      {kSearch, kHeld, kHold},      {kAcquire, kHeld, kHold},    {kTrack, kHeld, kHold},
      {kCoast, kHeld, kHold},       {kPark, kHeld, kHold},       {kSearch, kParked, kPark},
      {kAcquire, kParked, kPark},   {kTrack, kParked, kPark},    {kCoast, kParked, kPark},
      {kHold, kParked, kPark},      {kSearch, kSeen, kAcquire},  {kCoast, kSeen, kAcquire},
      {kHold, kSeen, kAcquire},     {kPark, kSeen, kAcquire},    {kAcquire, kCentred, kTrack},
      {kTrack, kStrayed, kAcquire}, {kAcquire, kMissed, kCoast}, {kTrack, kMissed, kCoast},
      {kCoast, kSought, kSearch},   {kHold, kSought, kSearch},   {kPark, kSought, kSearch},
      {kCoast, kGivenUp, kHold},    {kPark, kGivenUp, kHold}};
  for (const AimStateWords& state : kAimStates)
    for (const AimEventWords& event : kAimEvents) {
      const AimState to = next_aim_state(state.state, event.event);
      EXPECT_EQ(to != state.state, expected.contains({state.state, event.event, to}))
          << state.name << ", " << event.name << " -> " << name_of(to);
    }
}

TEST(AimTransitions, EveryStateIsReachedAndLeftAndNoneButHoldLastsWithoutALandmark) {
  for (const AimStateWords& state : kAimStates) {
    if (state.state == kNone) continue;
    EXPECT_TRUE(std::ranges::any_of(kAimTransitions, [&](const auto& t) { return t.to == state.state; })) << state.name;
    EXPECT_TRUE(std::ranges::any_of(kAimTransitions, [&](const auto& t) { return t.from == state.state; }));
    EXPECT_EQ(next_aim_state(state.state, of({kHeld})), kHold) << state.name;
  }
}

TEST(AimTransitions, WhatHoldsTheHeadComesBeforeWhatItSees) {
  EXPECT_EQ(next_aim_state(kTrack, of({kHeld, kParked, kSeen, kCentred})), kHold);
  EXPECT_EQ(next_aim_state(kHold, of({kHeld, kParked, kSeen})), kHold) << "not even to park";
  EXPECT_EQ(next_aim_state(kPark, of({kParked, kSeen, kSought})), kPark) << "who is parked looks at nothing";
  EXPECT_EQ(next_aim_state(kCoast, of({kSeen, kCentred, kSought})), kAcquire);
  EXPECT_EQ(next_aim_state(kAcquire, of({kSeen, kCentred})), kTrack);
  EXPECT_EQ(next_aim_state(kTrack, of({kSeen, kCentred})), kTrack);
  EXPECT_EQ(next_aim_state(kTrack, of({})), kTrack) << "between two frames";
}

TEST(AimTransitions, StandInTheDocumentAsTheyAreInTheCode) {
  std::ifstream file(NINEDOT_SOURCE_DIR "/docs/pan-tilt.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_NE(text.str().find(aim_transitions_markdown()), std::string::npos) << "docs/pan-tilt.md must hold:\n"
                                                                            << aim_transitions_markdown();
}

}  // namespace
}  // namespace ninedot
