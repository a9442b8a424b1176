#include "programs/assembly/row_time_text.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

TEST(RowTimeText, SaysNothingWhereThereIsNothingToSay) {
  EXPECT_EQ(row_time_text({33e-6, 0, RowTimeSource::kTold}), "");
  EXPECT_EQ(row_time_text({33e-6, 5e-6, RowTimeSource::kTold}), "") << "doubted";
  EXPECT_EQ(row_time_text({0, 33e-6, RowTimeSource::kOpen}), "");
}

TEST(RowTimeText, SaysWhatPicturesHaveShownAndHowItIsMeasured) {
  EXPECT_EQ(
      row_time_text({33.34e-6, 0.61e-6, RowTimeSource::kSeen}),
      "shutter: 33.3 us from row to row (1-sigma 0.6), as moving landmarks show; `ninedot calibrate rolling-shutter` "
      "measures it for the configuration");
  EXPECT_TRUE(row_time_text({-0.4e-6, 0.61e-6, RowTimeSource::kSeen})
                  .starts_with("shutter: all rows at once, to 0.6 us, as moving landmarks show; "));
  EXPECT_TRUE(
      row_time_text({-20e-6, 0.61e-6, RowTimeSource::kSeen})
          .starts_with("shutter: -20.0 us from row to row (1-sigma 0.6), the last one first: the picture stands on "
                       "its head, as moving landmarks show; "));
}

TEST(RowTimeText, SaysThatTheConfigurationIsWrong) {
  EXPECT_EQ(
      row_time_text({33.34e-6, 2.4e-6, RowTimeSource::kContradicted}),
      "shutter: camera.row_time_us is wrong: moving landmarks show 33.3 us from row to row (1-sigma 2.4); poses go "
      "by that; `ninedot calibrate rolling-shutter` measures it for the configuration");
}

}  // namespace
}  // namespace ninedot
