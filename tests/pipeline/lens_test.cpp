// A localiser whose lens changes: what it says of frames without one, that it starts anew behind another, and that the
// frame path allocates nothing meanwhile.
#include "pipeline/lens.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "pipeline/localiser.h"
#include "pipeline/room_localiser.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/zoom_choice.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr double kNoZoom = std::numeric_limits<double>::quiet_NaN();

/// A landmark at 1.5 m through a lens of 720 px, and the same picture as one of 1440 px has it.
class LensChange : public testing::Test {
 protected:
  static ZoomLens lens_of(int zoom) {
    ZoomLens lens{zoom, CameraModel{}};
    if (zoom > 0) lens.camera.fx_px = lens.camera.fy_px = 1440;
    lens.covariance(0, 0) = lens.covariance(1, 1) = 0.01;
    return lens;
  }

  LensChange() {
    scene_.camera = test::look_at_landmark({.distance_m = 1.5, .tilt_rad = 0.4});
    picture_ = test::render(scene_, 1);
    options_.new_lenses = &lenses_;
  }

  const Fix& look(FrameProcessor& localiser, double zoom) {
    Frame frame;
    frame.luma = picture_.view();
    frame.number = ++number_;
    frame.set_exposure(MonoTime(number_ * 30ms));
    frame.zoom = zoom;
    const test::AllocationGuard guard;
    const Fix& fix = localiser.process(frame);
    EXPECT_EQ(guard.allocations(), 0U) << number_;
    EXPECT_EQ(guard.releases(), 0U) << number_;
    return fix;
  }
  void expect_nothing(FrameProcessor& localiser, double zoom) {
    const Fix& fix = look(localiser, zoom);
    EXPECT_EQ(fix.reason, Reason::kZoom) << zoom;
    EXPECT_TRUE(fix.landmarks.empty());
    EXPECT_FALSE(fix.world || fix.track || fix.found || fix.tracked);
    EXPECT_EQ(localiser.last_observation(), nullptr);
  }
  static double distance_m(const Fix& fix) { return fix.main().pose().T_landmark_camera.translation_m.norm(); }

  test::Scene scene_;
  test::Picture picture_;
  LensExchange lenses_;
  LocaliserOptions options_;
  std::uint64_t number_ = 0;
};

TEST_F(LensChange, LooksThroughTheLensOfEachFrameAndAllocatesNothing) {
  const auto localiser = make_localiser(CameraModel{}, options_);
  EXPECT_EQ(look(*localiser, 0).reason, Reason::kZoom) << "no lens has been made yet";
  EXPECT_EQ(lenses_.wait_for_wish({}, MonoTime{}), 0);
  lenses_.put(make_lens(lens_of(0), options_));
  const Fix& near = look(*localiser, 0);
  ASSERT_FALSE(near.landmarks.empty());
  EXPECT_FALSE(near.tracked);
  EXPECT_NEAR(distance_m(near), 1.5, 0.01);
  EXPECT_GT(near.main().calibration_sigma_m, 0);
  EXPECT_TRUE(look(*localiser, 0).tracked);

  for (const double zoom : {kNoZoom, -1.0, 1e9, 7.0}) expect_nothing(*localiser, zoom);
  EXPECT_EQ(lenses_.wait_for_wish(0, MonoTime{}), 7);

  lenses_.put(make_lens(lens_of(7), options_));
  const Fix& far = look(*localiser, 7);
  ASSERT_FALSE(far.landmarks.empty());
  EXPECT_FALSE(far.tracked) << "behind another lens all begins anew";
  EXPECT_NEAR(distance_m(far), 3.0, 0.1);
  EXPECT_TRUE(look(*localiser, 7).tracked);

  expect_nothing(*localiser, 0);  // a lens that has been and gone is not there any more
  lenses_.put(make_lens(lens_of(0), options_));
  EXPECT_NEAR(distance_m(look(*localiser, 0)), 1.5, 0.01);
}

TEST_F(LensChange, DoesSoInARoomToo) {
  MappedLandmark one, other;
  one.id = 1, other.id = 2, other.code = "KRGBKKRB";
  options_.map = LandmarkMap({one, other});
  const auto localiser = make_localiser(CameraModel{}, options_);
  ASSERT_NE(dynamic_cast<RoomLocaliser*>(localiser.get()), nullptr);
  expect_nothing(*localiser, 0);
  for (const int zoom : {0, 7}) {
    lenses_.put(make_lens(lens_of(zoom), options_));
    const Fix& first = look(*localiser, zoom);
    EXPECT_TRUE(first.found);
    EXPECT_FALSE(first.tracked);
    EXPECT_EQ(first.reason, Reason::kNotIdentified) << "a grey picture";
    EXPECT_TRUE(look(*localiser, zoom).tracked);
    expect_nothing(*localiser, kNoZoom);
    EXPECT_TRUE(look(*localiser, zoom).found);
  }
}

TEST_F(LensChange, CountsOnWhereTheLensBeforeLeftOff) {
  LensInUse use(make_lens(lens_of(0), options_), &lenses_);
  Frame frame;
  frame.zoom = 7;
  EXPECT_EQ(use.fit_to(frame), LensInUse::Fit::kNone);
  lenses_.put(make_lens(lens_of(7), options_));
  EXPECT_EQ(use.fit_to(frame), LensInUse::Fit::kAnother);
  EXPECT_EQ(use->seeker.camera().fx_px, 1440);
  EXPECT_EQ(use.fit_to(frame), LensInUse::Fit::kSame);
}

TEST_F(LensChange, OneLensServesAllFramesWhereNoOtherCanCome) {
  LensInUse use(make_lens(lens_of(0), options_), nullptr);
  Frame frame;
  for (const double zoom : {kNoZoom, 0.0, 7.0}) {
    frame.zoom = zoom;
    EXPECT_EQ(use.fit_to(frame), LensInUse::Fit::kSame);
  }
}

TEST(LensExchange, WakesWhoWaitsForAWish) {
  LensExchange lenses;
  std::optional<int> wish;
  std::thread maker([&] {
    while (!wish) wish = lenses.wait_for_wish(3, mono_now() + 10s);
  });
  lenses.ask(3);
  lenses.ask(9);
  const MonoTime asked = mono_now();
  maker.join();
  EXPECT_EQ(wish, 9);
  EXPECT_LT(mono_now() - asked, 5s);
}

}  // namespace
}  // namespace ninedot
