#include "programs/commands/gathering_view.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace ninedot {
namespace {

GatheringState half_way() {
  GatheringState state;
  state.tally.views = 12;
  state.tally.parts = {3, 2, 1, 4, 9, 3, 0, 2, 1};
  state.wanted = {"lower left", "tilted to the right"};
  state.part = 4;
  state.looked = Looked::kMoving;
  return state;
}

TEST(GatheringTable, ShowsWhatIsWantedWhereViewsAreAndWhatToDo) {
  const std::string text = gathering_table(half_way(), 80);
  EXPECT_NE(text.find("12 views; wanted: lower left, tilted to the right\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nhold still\n"), std::string::npos) << text;
  EXPECT_NE(text.find("     3       2       1  \n"
                      "     4    [  9 ]     3  \n"
                      "     .       2       1  \n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("Ctrl-C"), std::string::npos);
  EXPECT_EQ(text.back(), '\n');
}

TEST(GatheringTable, SaysWhatToDoNext) {
  GatheringState state = half_way();
  const auto says = [&](Looked looked, const char* words) {
    state.looked = looked;
    EXPECT_NE(gathering_table(state, 80).find(words), std::string::npos) << gathering_table(state, 80);
  };
  says(Looked::kNoSheet, "no sheet in sight");
  says(Looked::kBlurred, "blurred: focus the lens");
  says(Looked::kTaken, "\ntaken\n");
  says(Looked::kSeenBefore, "move on, to lower left");
  state.lens_lacks = {"focal length uncertain by 3 %: tilt the sheet"};
  says(Looked::kSeenBefore, "focal length uncertain by 3 %");
}

TEST(GatheringTable, BreaksBetweenWordsWhatTheWindowCannotShow) {
  GatheringState state = half_way();
  state.wanted.insert(state.wanted.end(), {"tilted to the left", "nearer"});
  const std::string text = gathering_table(state, 30);
  EXPECT_TRUE(
      text.starts_with("12 views; wanted: lower left,\n"
                       "  tilted to the right, tilted\n"
                       "  to the left, nearer\n"))
      << text;
}

TEST(GatheringLine, IsOneLine) {
  GatheringState state = half_way();
  EXPECT_EQ(gathering_line(state), "12 views; wanted: lower left, tilted to the right");
  state.tally.views = 1, state.wanted = {}, state.lens_lacks = {"few views in the top"};
  EXPECT_EQ(gathering_line(state), "1 view; wanted: nothing (few views in the top)");
}

}  // namespace
}  // namespace ninedot
