#include <fmt/format.h>

#include <cstdlib>

#include "tests/bench/apriltag_headers.h"
#include "tests/bench/contenders.h"
#include "tests/bench/tag_picture.h"

namespace ninedot::bench {
namespace {

class AprilTag final : public Contender {
 public:
  AprilTag(const CameraModel& camera, float quad_decimate) : camera_(camera) {
    apriltag_detector_add_family(detector_.get(), family_.get());
    detector_->quad_decimate = quad_decimate;
    detector_->refine_edges = true;
    detector_->nthreads = 1;
  }
  std::string name() const override {
    return fmt::format("AprilTag 3, quad_decimate {:.0f}", detector_->quad_decimate);
  }
  bool looks_for_tag() const override { return true; }
  std::optional<Eigen::Vector3d> locate(const ImageView& luma) override {
    // The library takes a writable picture and does not write to it.
    image_u8_t image{luma.width_px, luma.height_px, static_cast<std::int32_t>(luma.stride_bytes),
                     const_cast<std::uint8_t*>(luma.pixels)};
    const std::unique_ptr<zarray_t, void (*)(zarray_t*)> found(apriltag_detector_detect(detector_.get(), &image),
                                                               apriltag_detections_destroy);
    std::optional<Eigen::Vector3d> position_m;
    for (int i = 0; i < zarray_size(found.get()); ++i) {
      apriltag_detection_t* detection = nullptr;
      zarray_get(found.get(), i, &detection);
      if (detection->id == 0) position_m = camera_position_from(detection);
    }
    return position_m;
  }

 private:
  Eigen::Vector3d camera_position_from(apriltag_detection_t* detection) const {
    apriltag_detection_info_t info{detection, kTagSide_m, camera_.fx_px, camera_.fy_px, camera_.cx_px, camera_.cy_px};
    apriltag_pose_t pose{};
    estimate_tag_pose(&info, &pose);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(pose.R->data);
    const Eigen::Map<const Eigen::Vector3d> translation_m(pose.t->data);
    const Eigen::Vector3d position_m = camera_position_m(rotation, translation_m);
    // matd_destroy is `free` under another name, and Debian's library does not export it.
    std::free(pose.R);
    std::free(pose.t);
    return position_m;
  }

  CameraModel camera_;
  std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family_{tag36h11_create(), tag36h11_destroy};
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector_{apriltag_detector_create(),
                                                                                 apriltag_detector_destroy};
};

}  // namespace

std::unique_ptr<Contender> make_apriltag(const CameraModel& camera, float quad_decimate) {
  return std::make_unique<AprilTag>(camera, quad_decimate);
}

}  // namespace ninedot::bench
