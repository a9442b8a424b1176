#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "detect/detector.h"
#include "pipeline/localiser.h"
#include "pose/full_solver.h"
#include "tests/bench/contenders.h"
#include "tests/support/best_pose.h"
#include "tests/support/process_picture.h"
#include "tests/support/random.h"

namespace ninedot::bench {
namespace {

class FullSearch final : public Contender {
 public:
  explicit FullSearch(const CameraModel& camera) : detector_(camera, landmark_), solver_(camera, landmark_) {}
  std::string name() const override { return "ninedot, full search"; }
  bool looks_for_tag() const override { return false; }
  std::optional<Eigen::Vector3d> locate(const ImageView& luma) override {
    const auto seen = detector_.find_landmarks(luma);
    if (!seen) return std::nullopt;
    int pixels = WorkBudget{}.pixels;
    const auto pose = test::best_pose(solver_.solve(luma, seen->front(), nullptr, pixels));
    if (!pose) return std::nullopt;
    return pose->T_landmark_camera.translation_m;
  }

 private:
  LandmarkGeometry landmark_;
  Detector detector_;
  FullSolver solver_;
};

/// The last of four pictures in which the landmark moves sideways, each under noise of its own.
class Tracking final : public Contender {
 public:
  Tracking(const CameraModel& camera, int px_per_frame) : px_per_frame_(px_per_frame), localiser_(camera, {}) {}
  std::string name() const override {
    return px_per_frame_ == 0 ? "ninedot, tracking" : fmt::format("ninedot, tracking, {} px per frame", px_per_frame_);
  }
  bool looks_for_tag() const override { return false; }
  void prepare(const ImageView& luma) override {
    for (int frames_ago = 3; frames_ago > 0; --frames_ago) {
      draw_before(luma, frames_ago);
      process({before_.data(), luma.width_px, luma.height_px, luma.width_px});
    }
  }
  std::optional<Eigen::Vector3d> locate(const ImageView& luma) override {
    process(luma);
    if (!report_.valid || !report_.tracking) return std::nullopt;
    return Eigen::Vector3d(report_.camera_in_landmark.position_m.data());
  }

 private:
  void draw_before(const ImageView& luma, int frames_ago) {
    constexpr double kNoise_lsb = 1.5;
    test::Random random(static_cast<std::uint64_t>(frames_ago));
    before_.clear();
    for (int y = 0; y < luma.height_px; ++y)
      for (int x = 0; x < luma.width_px; ++x) {
        const int from_x = std::min(x + frames_ago * px_per_frame_, luma.width_px - 1);
        const double level = luma.at(from_x, y) + kNoise_lsb * random.normal();
        before_.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L)));
      }
  }
  void process(const ImageView& luma) {
    ++frame_;
    test::process_picture(localiser_, luma, MonoTime(std::chrono::milliseconds(30 * frame_)),
                          static_cast<std::uint64_t>(frame_), report_);
  }

  const int px_per_frame_;
  std::vector<std::uint8_t> before_;
  Localiser localiser_;
  Report report_;
  int frame_ = 0;
};

}  // namespace

std::unique_ptr<Contender> make_full_search(const CameraModel& camera) { return std::make_unique<FullSearch>(camera); }
std::unique_ptr<Contender> make_tracking(const CameraModel& camera, int px_per_frame) {
  return std::make_unique<Tracking>(camera, px_per_frame);
}

}  // namespace ninedot::bench
