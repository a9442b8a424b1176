#pragma once
/// What is timed against what: each finds its marker in a picture and computes the camera's pose, on one thread.
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera_model.h"
#include "image/image_view.h"

namespace ninedot::bench {

/// Built once per camera; `locate` is what is timed.
class Contender {
 public:
  virtual ~Contender() = default;
  virtual std::string name() const = 0;
  /// Its marker is in the tagged pictures (paste_tag), not in the recording's own.
  virtual bool looks_for_tag() const = 0;
  /// Untimed preparation for pictures like this one.
  virtual void prepare(const ImageView&) {}
  /// Camera in S0 [m], or none when nothing was found.
  virtual std::optional<Eigen::Vector3d> locate(const ImageView& luma) = 0;
};

/// The whole picture is searched each time.
std::unique_ptr<Contender> make_full_search(const CameraModel& camera);
/// Only where the landmark is expected after three frames that `prepare` makes up: the same picture, moved sideways,
/// under noise of its own. \param px_per_frame  by so much
std::unique_ptr<Contender> make_tracking(const CameraModel& camera, int px_per_frame);
/// libapriltag, tag36h11, refine_edges 1, one thread, with estimate_tag_pose.
std::unique_ptr<Contender> make_apriltag(const CameraModel& camera, float quad_decimate);
/// OpenCV's ArUco with the same dictionary, sub-pixel corners, and solvePnP (IPPE for squares).
std::unique_ptr<Contender> make_aruco(const CameraModel& camera);

}  // namespace ninedot::bench
