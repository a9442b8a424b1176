#include "detect/detector.h"
#include "pose/full_solver.h"
#include "tests/bench/contenders.h"

namespace ninedot::bench {
namespace {

class FullSearch final : public Contender {
 public:
  explicit FullSearch(const CameraModel& camera) : detector_(camera, landmark_), solver_(camera, landmark_) {}
  std::string name() const override { return "ninedot, full search"; }
  bool looks_for_tag() const override { return false; }
  std::optional<Eigen::Vector3d> locate(const ImageView& luma) override {
    const auto seen = detector_.find_landmark(luma);
    if (!seen) return std::nullopt;
    const auto pose = solver_.solve(luma, *seen, nullptr);
    if (!pose) return std::nullopt;
    return pose->T_landmark_camera.translation_m;
  }

 private:
  LandmarkGeometry landmark_;
  Detector detector_;
  FullSolver solver_;
};

class Tracking final : public Contender {
 public:
  explicit Tracking(const CameraModel& camera) : detector_(camera, landmark_), solver_(camera, landmark_) {}
  std::string name() const override { return "ninedot, tracking"; }
  bool looks_for_tag() const override { return false; }
  void prepare(const ImageView& luma) override {
    known_ = false;
    const auto seen = detector_.find_landmark(luma);
    if (!seen) return;
    const auto pose = solver_.solve(luma, *seen, nullptr);
    if (!pose) return;
    seen_ = *seen, pose_ = *pose, known_ = true;
  }
  std::optional<Eigen::Vector3d> locate(const ImageView& luma) override {
    if (!known_) return std::nullopt;
    const auto seen = detector_.find_landmark_near(luma, seen_);
    if (!seen) return std::nullopt;
    const auto pose = solver_.solve(luma, *seen, &pose_);
    if (!pose) return std::nullopt;
    seen_ = *seen, pose_ = *pose;
    return pose_.T_landmark_camera.translation_m;
  }

 private:
  LandmarkGeometry landmark_;
  Detector detector_;
  FullSolver solver_;
  LandmarkObservation seen_;
  PoseEstimate pose_;
  bool known_ = false;
};

}  // namespace

std::unique_ptr<Contender> make_full_search(const CameraModel& camera) { return std::make_unique<FullSearch>(camera); }
std::unique_ptr<Contender> make_tracking(const CameraModel& camera) { return std::make_unique<Tracking>(camera); }

}  // namespace ninedot::bench
