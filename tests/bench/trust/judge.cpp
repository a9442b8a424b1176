#include "tests/bench/trust/judge.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>

#include "pipeline/room_localiser.h"
#include "tests/support/process_picture.h"
#include "tests/support/renderer_optics.h"

namespace ninedot::bench {
namespace {

CameraModel camera_of(const test::Lens& lens) {
  CameraModel camera;
  camera.width_px = lens.width_px, camera.height_px = lens.height_px;
  camera.fx_px = lens.fx_px, camera.fy_px = lens.fy_px, camera.cx_px = lens.cx_px, camera.cy_px = lens.cy_px;
  return camera;
}

constexpr std::uint8_t kNoColour = 128;

// Of this thread alone: others may run beside it.
double processor_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

std::unique_ptr<FrameProcessor> processor_for(const Strip& strip) {
  const CameraModel camera = camera_of(trust_lens());
  if (!strip.in_room) return std::make_unique<Localiser>(camera, LocaliserOptions{});
  LocaliserOptions options;  // its map is the one sheet
  options.row_time = std::chrono::nanoseconds(0);
  return std::make_unique<RoomLocaliser>(camera, options);
}

}  // namespace

void compare(const ClaimedPose& claimed, const Shot& shot, Verdict& verdict) {
  if (!shot.truth) {
    verdict.wrong = true;
    return;
  }
  const Eigen::Vector3d truth_m(shot.truth->position_m.data());
  const auto& q = claimed.quaternion_wxyz;
  const Eigen::Matrix3d R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(R.transpose() * test::rotation_of(*shot.truth)));
  const Eigen::Matrix<double, 6, 6> covariance(claimed.covariance.data());  // symmetric
  Eigen::Matrix<double, 6, 1> error;
  error << truth_m - Eigen::Vector3d(claimed.position_m.data()), turn.angle() * turn.axis();
  verdict.error_m = error.head<3>().norm(), verdict.turn_rad = turn.angle();
  const double allowed_m = kSigmas * std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace()));
  const double allowed_rad = kSigmas * std::sqrt(std::max(0.0, covariance.bottomRightCorner<3, 3>().trace()));
  // Not-a-number is beyond and wrong.
  verdict.beyond = !(verdict.error_m <= allowed_m && turn.angle() <= allowed_rad);
  verdict.wrong = !(verdict.error_m <= std::max(allowed_m, kWrong * truth_m.norm()) &&
                    turn.angle() <= std::max(allowed_rad, kWrong));
  if (verdict.wrong) return;
  verdict.nees = error.dot(covariance.ldlt().solve(error));
  if (shot.bound_m > 0) verdict.error_over_bound = verdict.error_m / shot.bound_m;
}

std::vector<Verdict> judge(const Strip& strip, CameraKind camera) {
  const std::unique_ptr<FrameProcessor> processor = processor_for(strip);
  Report report;
  std::vector<Verdict> verdicts;
  for (std::size_t i = 0; i < strip.shots.size(); ++i) {
    const Shot& shot = strip.shots[i];
    const std::vector<std::uint8_t> grey(shot.picture.pixels.size() / 4, kNoColour);
    const int width = shot.picture.width_px / 2, height = shot.picture.height_px / 2;
    const ChromaView chroma =
        camera == CameraKind::kColour ? ChromaView{grey.data(), grey.data(), width, height, 1, width} : ChromaView{};
    const double begin_ms = processor_ms();
    test::process_picture(*processor, shot.picture.view(), MonoTime(std::chrono::seconds(1) + shot.at), i, report,
                          chroma);
    Verdict verdict;
    verdict.work_ms = processor_ms() - begin_ms;
    verdict.shown = shot.truth.has_value();
    verdict.found = report.found;
    verdict.valid = report.valid && !report.ambiguous;
    if (verdict.valid)
      compare({report.camera_in_landmark.position_m, report.camera_in_landmark.quaternion_wxyz, report.covariance},
              shot, verdict);
    verdicts.push_back(verdict);
  }
  return verdicts;
}

}  // namespace ninedot::bench
