// Two landmarks that contradict each other, from picture to report: somebody has to learn which two.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "pipeline/next_report.h"
#include "pipeline/room_localiser.h"
#include "tests/support/rendered_truth.h"
#include "tests/support/renderer_optics.h"
#include "tests/support/room_renderer.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// Coded sheets on one wall, before a camera that stands.
struct Wall {
  test::Lens lens;
  test::Sensor sensor;
  test::Room room;
  std::vector<MappedLandmark> mapped;

  /// \param moved_by_m  along the wall, from where the map says
  void hang(std::uint16_t id, double along_m, double height_m, double moved_by_m = 0) {
    const std::string code(known_code(id).value());
    test::HungLandmark hung{test::RoomSide::kHighX, along_m, height_m, test::inks_of_code(code)};
    const Eigen::Vector3d x0 = test::axes_of(hung.side).col(0);
    mapped.push_back({id, code, place_upright(test::place_of(room, hung), std::atan2(x0.y(), x0.x()))});
    hung.along_m += moved_by_m;
    room.landmarks.push_back(hung);
  }

  test::ColourPicture picture() const {
    Eigen::Matrix3d level;
    level << -Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX();
    const Eigen::Quaterniond q(level);
    const test::CameraPose camera{{2.2, 0.25, 1.3}, {q.w(), q.x(), q.y(), q.z()}};
    return read_out(test::RoomRenderer(room, lens, sensor).expose([&](double) { return camera; }, {}), sensor,
                    test::ChromaLayout::k420, 7);
  }
};

Frame frame_of(const test::ColourPicture& picture, std::uint64_t number) {
  Frame frame;
  frame.number = number;
  frame.luma = picture.luma.view(), frame.chroma = picture.chroma();
  frame.set_exposure(MonoTime(5s + number * 28ms));
  return frame;
}

TEST(RoomDisputes, NameBothUntilAThirdOneDecides) {
  Wall wall;
  set_noise(wall.sensor, 1.5);
  wall.hang(1, -0.3, 1.1);
  wall.hang(2, 0.35, 1.4, 0.15);
  const test::ColourPicture two = wall.picture();
  wall.hang(3, 0.85, 1.15);
  const test::ColourPicture three = wall.picture();
  RoomLocaliser unit(test::pinhole_of(wall.lens), {.row_time = 0ns, .map = LandmarkMap(wall.mapped)});

  const Fix& tie = unit.process(frame_of(two, 1));
  EXPECT_FALSE(tie.world);
  EXPECT_EQ(tie.reason, Reason::kAmbiguous);
  const Report told = next_report({}, frame_of(two, 1), tie, {});
  EXPECT_GT(told.ambiguity, 0.01) << "of the camera's place: each landmark by itself is sure";
  EXPECT_EQ(told.landmarks_disputed, 2);
  EXPECT_EQ(told.disputed_ids, (std::array<std::uint16_t, 2>{1, 2}));

  const Fix& decided = unit.process(frame_of(three, 2));
  ASSERT_TRUE(decided.world);
  ASSERT_EQ(decided.rejected.size(), 1U);
  EXPECT_EQ(decided.rejected[0], 2);
  const Report known = next_report(told, frame_of(three, 2), decided, {});
  EXPECT_EQ(known.landmarks_disputed, 0);
  EXPECT_EQ(known.disputed_ids, Report{}.disputed_ids);
  EXPECT_EQ(known.last_rejected_id, 2);
}

}  // namespace
}  // namespace ninedot
