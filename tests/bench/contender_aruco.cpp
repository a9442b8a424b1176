#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/version.hpp>
// ArUco moved from OpenCV's extra modules into its main ones with 4.7, and changed its calls on the way.
#define NINEDOT_ARUCO_IN_OBJDETECT (CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7))
#if NINEDOT_ARUCO_IN_OBJDETECT
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#include <opencv2/aruco.hpp>
#endif

#include "tests/bench/contenders.h"
#include "tests/bench/tag_picture.h"

namespace ninedot::bench {
namespace {

/// Default 0.05: the sheet's own rim then counts as the same marker as the tag in it, and the larger of the two is
/// kept.
constexpr double kMinMarkerDistanceRate = 0.01;

using Corners = std::vector<std::vector<cv::Point2f>>;

#if NINEDOT_ARUCO_IN_OBJDETECT
class MarkerFinder {
 public:
  void find(const cv::Mat& image, Corners& corners, std::vector<int>& ids) const {
    detector_.detectMarkers(image, corners, ids);
  }

 private:
  static cv::aruco::DetectorParameters parameters() {
    cv::aruco::DetectorParameters result;
    result.cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
    result.minMarkerDistanceRate = kMinMarkerDistanceRate;
    return result;
  }
  cv::aruco::ArucoDetector detector_{cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11), parameters()};
};
#else
class MarkerFinder {
 public:
  MarkerFinder() {
    parameters_->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
    parameters_->minMarkerDistanceRate = kMinMarkerDistanceRate;
  }
  void find(const cv::Mat& image, Corners& corners, std::vector<int>& ids) const {
    cv::aruco::detectMarkers(image, dictionary_, corners, ids, parameters_);
  }

 private:
  cv::Ptr<cv::aruco::Dictionary> dictionary_ = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
  cv::Ptr<cv::aruco::DetectorParameters> parameters_ = cv::aruco::DetectorParameters::create();
};
#endif

class ArUco final : public Contender {
 public:
  explicit ArUco(const CameraModel& camera)
      : intrinsics_(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1),
        distortion_(camera.k[0], camera.k[1], camera.k[2], camera.k[3], camera.k[4]) {
    cv::setNumThreads(1);
  }
  std::string name() const override { return "OpenCV ArUco"; }
  bool looks_for_tag() const override { return true; }
  std::optional<Eigen::Vector3d> locate(const ImageView& luma) override {
    const cv::Mat image(luma.height_px, luma.width_px, CV_8UC1, const_cast<std::uint8_t*>(luma.pixels),
                        static_cast<std::size_t>(luma.stride_bytes));
    Corners corners;
    std::vector<int> ids;
    finder_.find(image, corners, ids);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (ids[i] == 0) return solve(corners[i]);
    }
    return std::nullopt;
  }

 private:
  std::optional<Eigen::Vector3d> solve(const std::vector<cv::Point2f>& corners) const {
    constexpr float kHalf_m = static_cast<float>(kTagSide_m / 2);
    // IPPE for squares wants the top left corner first, clockwise, x right, y up, z towards the viewer. OpenCV's copy
    // of the dictionary is turned by 180 degrees against AprilTag's own pictures: its first corner is our bottom right
    // one.
    static const std::vector<cv::Point3f> object{
        {-kHalf_m, kHalf_m, 0}, {kHalf_m, kHalf_m, 0}, {kHalf_m, -kHalf_m, 0}, {-kHalf_m, -kHalf_m, 0}};
    cv::Vec3d rotation, translation;
    if (!cv::solvePnP(object, corners, intrinsics_, distortion_, rotation, translation, false,
                      cv::SOLVEPNP_IPPE_SQUARE))
      return std::nullopt;
    cv::Matx33d R;
    cv::Rodrigues(rotation, R);
    const cv::Vec3d in_tag_m = -(R.t() * translation);
    return Eigen::Vector3d(in_tag_m[0], in_tag_m[2], -in_tag_m[1]);
  }

  cv::Matx33d intrinsics_;
  cv::Vec<double, 5> distortion_;
  MarkerFinder finder_;
};

}  // namespace

std::unique_ptr<Contender> make_aruco(const CameraModel& camera) { return std::make_unique<ArUco>(camera); }

}  // namespace ninedot::bench
