// How well lenses are known after a calibration: true lenses of all three models, rendered views, and the error of the
// directions that the calibration gives to pixels, beside what it says itself and beside OpenCV's calibrateCamera and
// mrcal on the same frames.
//
//     bench_calibrate [--views 60] [--seeds 3] [--lens NAME] [--grid]    rendered here; a grid of dots in place of the
//     landmark, which mrcal takes too
//     bench_calibrate RECORDING...                               with a camera_true.yaml
//     bench_calibrate --outlines [--seeds 20] [--lens NAME]      errors of the parameters in their sigmas, no pictures
//     bench_calibrate --save FOLDER [--lens NAME]                a rendered recording, and views.png: twelve of its
//     pictures
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibrate_camera/lens_calibration.h"
#include "calibrate_camera/lens_parameters.h"
#include "calibrate_camera/sheet_finder.h"
#include "drivers/picture/picture_file.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/calibration_target.h"
#include "programs/commands/collect_views.h"
#include "tests/bench/mrcal_lens.h"
#include "tests/calibrate_camera/lens_scene.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

using namespace ninedot::test;
using Clock = std::chrono::steady_clock;

struct TrueLens {
  const char* name;
  CameraModel camera;
};

std::vector<TrueLens> lenses() {
  const auto lens = [](double fx, double fy, double cx, double cy, DistortionModel model, std::array<double, 8> k) {
    return CameraModel{640, 480, fx, fy, cx, cy, model, k};
  };
  return {
      {"plain", lens(720, 720, 319.5, 239.5, DistortionModel::kPlumbBob, {})},
      {"barrel", lens(612.3, 611.1, 323.1, 236.4, DistortionModel::kPlumbBob, {-0.21, 0.06, 0.0007, -0.0004, 0.01})},
      {"wide", lens(402.7, 403.5, 314.2, 244.9, DistortionModel::kPlumbBob, {-0.30, 0.11, -0.0006, 0.0008, -0.016})},
      {"rational", lens(388.1, 388.9, 322.7, 238.1, DistortionModel::kRationalPolynomial,
                        {1.6, 0.35, 0.0004, -0.0003, 0.012, 1.95, 0.72, 0.06})},
      {"fisheye", lens(262.4, 262.9, 317.8, 241.6, DistortionModel::kEquidistant, {0.021, -0.009, 0.004, -0.001})}};
}

CalibrationTarget the_landmark() {
  CalibrationTarget target;
  target.discs = discs_of(target.landmark);
  return target;
}
CalibrationTarget the_grid() {
  CalibrationTarget target;
  target.grid = DotGrid{9, 7, 0.025};
  target.discs = discs_of(*target.grid);
  return target;
}

Sheet printed(const CalibrationTarget& target) { return target.grid ? dot_grid_sheet(*target.grid) : nine_dot_sheet(); }

std::vector<SheetView> views_of(const CameraModel& truth, const CalibrationTarget& target, std::size_t count,
                                std::uint64_t seed, double& search_s) {
  const std::unique_ptr<SheetFinder> finder = target.finder(usual_camera(truth.width_px, truth.height_px));
  Holding holding;
  holding.min_distance_m *= truth.fx_px / 612, holding.max_distance_m *= truth.fx_px / 612;
  std::vector<SheetView> views;
  std::uint64_t index = 0;
  for (; views.size() < count && index < 3 * count; ++index) {
    const Picture picture =
        held_picture(truth, held_pose(truth, holding, seed, index), printed(target), random_bits(seed, 1000 + index));
    const auto begun = Clock::now();
    std::vector<SeenDisc> seen = finder->find(picture.view());
    if (!seen.empty()) {
      views.push_back(keep_view(picture.view(), SensorKind::kGrey, std::move(seen), target.discs));
      views.back().frame = index;
    }
    search_s += std::chrono::duration<double>(Clock::now() - begun).count();
  }
  return views;
}

/// Centres of ellipses through the outlines that ours were measured on: the best that a user of OpenCV can give it.
std::vector<SheetView> with_ellipse_centres(const LensCalibration& known, const CalibrationTarget& target) {
  std::vector<SheetView> views = known.views;
  for (SheetView& view : views) {
    std::vector<SeenDisc> seen;
    for (std::size_t disc = 0; disc < target.discs.size(); ++disc) {
      std::vector<cv::Point2f> outline;
      for (const EdgePoint& edge : view.edges)
        if (edge.disc == disc)
          outline.emplace_back(static_cast<float>(edge.at_px.x()), static_cast<float>(edge.at_px.y()));
      if (outline.size() < 8) continue;
      const cv::RotatedRect ellipse = cv::fitEllipseDirect(outline);
      seen.push_back({disc, {ellipse.center.x, ellipse.center.y}});
    }
    view.seen = std::move(seen);
  }
  std::erase_if(views, [](const SheetView& view) { return view.seen.size() < 6; });
  return views;
}

/// Where the middle of each disc is seen, given where its centroid is: what a user of OpenCV had to work out by
/// himself.
std::vector<SheetView> with_middles(const LensCalibration& known, const CalibrationTarget& target) {
  std::vector<SheetView> views = with_ellipse_centres(known, target);
  for (SheetView& view : views)
    for (SeenDisc& seen : view.seen) {
      const PlaneDisc& disc = target.discs[seen.disc];
      const auto at = std::ranges::find(known.views, view.frame, &SheetView::frame) - known.views.begin();
      const CameraFromLandmark& T = known.fit.views[static_cast<std::size_t>(at)].T_camera_sheet;
      seen.centre_px += known.fit.camera.pixel_from_normalised(project_plane_point(T, disc.centre_m)) -
                        known.fit.camera.pixel_from_normalised(project_disc_centre(T, disc.centre_m, disc.radius_m));
    }
  return views;
}

CameraModel by_opencv(const CameraModel& truth, const std::vector<PlaneDisc>& discs,
                      const std::vector<SheetView>& views, double& seconds) {
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> pictures;
  for (const SheetView& view : views) {
    objects.emplace_back(), pictures.emplace_back();
    for (const SeenDisc& seen : view.seen) {
      const Eigen::Vector2d at = discs[seen.disc].centre_m;
      // OpenCV's boards lie in z = 0 with x to the right.
      objects.back().emplace_back(static_cast<float>(-at.x()), static_cast<float>(-at.y()), 0.0F);
      pictures.back().emplace_back(static_cast<float>(seen.centre_px.x()), static_cast<float>(seen.centre_px.y()));
    }
  }
  cv::Mat K = cv::Mat::eye(3, 3, CV_64F), distortion;
  std::vector<cv::Mat> rotations, translations;
  const cv::Size size(truth.width_px, truth.height_px);
  const auto begun = Clock::now();
  if (truth.model == DistortionModel::kEquidistant)
    cv::fisheye::calibrate(objects, pictures, size, K, distortion, rotations, translations,
                           cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW);
  else
    cv::calibrateCamera(objects, pictures, size, K, distortion, rotations, translations,
                        truth.model == DistortionModel::kRationalPolynomial ? cv::CALIB_RATIONAL_MODEL : 0);
  seconds += std::chrono::duration<double>(Clock::now() - begun).count();
  CameraModel camera = truth;
  camera.fx_px = K.at<double>(0, 0), camera.fy_px = K.at<double>(1, 1);
  camera.cx_px = K.at<double>(0, 2), camera.cy_px = K.at<double>(1, 2);
  camera.k = {};
  for (int i = 0; i < coefficient_count(camera.model); ++i)
    camera.k[static_cast<std::size_t>(i)] = distortion.at<double>(i);
  return camera;
}

/// As a user of OpenCV does it.
DirectionErrors opencv_errors(const CameraModel& truth, const std::vector<PlaneDisc>& discs,
                              const std::vector<SheetView>& views, double& seconds) {
  try {
    return direction_differences(truth, by_opencv(truth, discs, views, seconds));
  } catch (const cv::Exception&) {
    return {};
  }
}

/// "median max" of mrcal, or why there is none: it takes boards that are a regular grid.
std::string mrcal_words(const CameraModel& truth, const CalibrationTarget& target,
                        const std::vector<SheetView>& views) {
  static const bool is_installed = has_mrcal();
  if (!target.grid) return "no grid";
  if (!is_installed) return "not installed";
  const std::optional<CameraModel> lens = lens_by_mrcal(truth, *target.grid, views);
  if (!lens) return "failed";
  const DirectionErrors off = direction_differences(truth, *lens);
  return fmt::format("{:>8.4f} {:>8.4f}", off.median_px(), off.max_px());
}

/// One line of the table. \return  squares of the parameters' errors in their sigmas, and how many; 0 where the models
/// differ
std::pair<double, double> report(const std::string& name, const std::string& seed, const CameraModel& truth,
                                 const CalibrationTarget& target, std::vector<SheetView> views, double search_s) {
  LensCalibrationOptions options;
  options.width_px = truth.width_px, options.height_px = truth.height_px;
  const auto begun = Clock::now();
  const auto result = calibrate_lens(target.discs, std::move(views), options);
  const double seconds = search_s + std::chrono::duration<double>(Clock::now() - begun).count();
  fmt::print("{:<9} {:>4} ", name, seed);
  std::pair<double, double> squares{0, 0};
  if (!result) {
    fmt::print("no lens\n");
    return squares;
  }
  const DirectionErrors off = direction_differences(truth, result->fit.camera);
  double opencv_s = 0, ignored_s = 0;
  const DirectionErrors opencv = opencv_errors(truth, target.discs, with_ellipse_centres(*result, target), opencv_s);
  const std::vector<SheetView> middles = with_middles(*result, target);
  const DirectionErrors corrected = opencv_errors(truth, target.discs, middles, ignored_s);
  double z_rms = 0;
  if (result->fit.camera.model == truth.model) {
    const Eigen::VectorXd error = parameters_of(result->fit.camera) - parameters_of(truth);
    const Eigen::VectorXd z = error.cwiseQuotient(result->covariance.matrix.diagonal().cwiseSqrt());
    squares = {z.squaredNorm(), static_cast<double>(z.size())};
    z_rms = std::sqrt(squares.first / squares.second);
  }
  fmt::print(
      "{:>3} {:<19} |{:>7.4f} {:>7.4f} |{:>7.4f} {:>7.4f} |{:>5.2f} |{:>7.4f} {:>6.4f} {:>5.2f} |{:>6.2f} |{:>8.3f} "
      "{:>8.3f} {:>6.2f} |{:>8.4f} {:>8.4f} |{:>18}\n",
      result->views.size(), name_of(result->fit.camera.model), off.median_px(), off.max_px(),
      result->directions.median_px(), result->directions.max_px(), z_rms, result->rms_px, result->fit.floor_px,
      result->covariance.variance_factor, seconds, opencv.median_px(), opencv.max_px(), opencv_s, corrected.median_px(),
      corrected.max_px(), mrcal_words(truth, target, middles));
  std::fflush(stdout);
  return squares;
}

void print_heading() {
  fmt::print("{:<9} {:>4} {:>3} {:<19} |{:^15} |{:^15} |{:^5} |{:^20} |{:>6} |{:^25} |{:^18} |{:^18}\n", "", "", "", "",
             "error px", "said px", "z", "outlines px", "time", "OpenCV, ellipse centres", "OpenCV, middles",
             "mrcal, middles");
  fmt::print(
      "{:<9} {:>4} {:>3} {:<19} |{:>7} {:>7} |{:>7} {:>7} |{:>5} |{:>7} {:>6} {:>5} |{:>6} |{:>8} {:>8} {:>6} |"
      "{:>8} {:>8} |{:>9} {:>8}\n",
      "lens", "seed", "n", "model", "median", "max", "median", "max", "rms", "rms", "floor", "f", "s", "median", "max",
      "s", "median", "max", "median", "max");
}

void run_rendered(const CalibrationTarget& target, std::size_t count, std::uint64_t seeds, const std::string& only) {
  for (const TrueLens& lens : lenses()) {
    if (!only.empty() && only != lens.name) continue;
    std::pair<double, double> sum{0, 0};
    for (std::uint64_t seed = 101; seed < 101 + seeds; ++seed) {
      double search_s = 0;
      std::vector<SheetView> views = views_of(lens.camera, target, count, seed, search_s);
      const auto squares = report(lens.name, std::to_string(seed), lens.camera, target, std::move(views), search_s);
      sum.first += squares.first, sum.second += squares.second;
    }
    if (sum.second > 0)
      fmt::print("{:<9} errors of the parameters in their sigmas, rms: {:.2f}\n", lens.name,
                 std::sqrt(sum.first / sum.second));
  }
}

/// Outlines alone, with errors of 0.02 px and no pictures: many trials of estimate and covariance in little time. One
/// line: the root mean square of the parameters' errors in their sigmas, of the worst of them, and directions.
void run_outlines(std::size_t count, std::uint64_t seeds, const std::string& only) {
  const std::vector<PlaneDisc> discs = discs_of(LandmarkGeometry{});
  for (const TrueLens& lens : lenses()) {
    if (!only.empty() && only != lens.name) continue;
    const CameraModel& truth = lens.camera;
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(parameter_count(truth.model));
    double off_px = 0, off_max_px = 0, said_px = 0, said_max_px = 0;
    for (std::uint64_t seed = 501; seed < 501 + seeds; ++seed) {
      std::vector<SheetView> views;
      LensFit fit{truth, {}, 0, 0};
      Holding holding;
      holding.min_distance_m *= truth.fx_px / 612, holding.max_distance_m *= truth.fx_px / 612;
      for (std::uint64_t i = 0; views.size() < count; ++i) {
        const CameraPose pose = held_pose(truth, holding, seed, i);
        SheetView view = perfect_view(truth, pose, discs, 0.02, random_bits(seed, i));
        if (view.seen.size() < 5) continue;
        views.push_back(std::move(view));
        fit.views.push_back({sheet_before(pose), 0});
      }
      if (!adjust_lens(discs, views, fit, {})) continue;
      const Eigen::MatrixXd covariance = lens_covariance(discs, views, fit).matrix;
      squares += (parameters_of(fit.camera) - parameters_of(truth)).cwiseAbs2().cwiseQuotient(covariance.diagonal());
      const DirectionErrors off = direction_differences(truth, fit.camera);
      const DirectionErrors said = direction_errors(fit.camera, covariance);
      off_px += off.median_px(), off_max_px += off.max_px();
      said_px += said.median_px(), said_max_px += said.max_px();
    }
    const Eigen::VectorXd z = (squares / static_cast<double>(seeds)).cwiseSqrt();
    const auto mean = [&](double sum) { return sum / static_cast<double>(seeds); };
    fmt::print("{:<9} z rms {:.2f}, worst {:.2f} | error px {:.4f} {:.4f} | said px {:.4f} {:.4f} |", lens.name,
               std::sqrt(z.squaredNorm() / static_cast<double>(z.size())), z.maxCoeff(), mean(off_px), mean(off_max_px),
               mean(said_px), mean(said_max_px));
    for (const double one : z) fmt::print(" {:.2f}", one);
    fmt::print("\n");
  }
}

/// A quarter of the size, each pixel the mean of those that it stands for.
void put_small(const Picture& picture, int left, int top, int width, std::vector<std::uint8_t>& to) {
  for (int y = 0; y + 3 < picture.height_px; y += 4)
    for (int x = 0; x + 3 < picture.width_px; x += 4) {
      int sum = 0;
      for (int i = 0; i < 16; ++i) sum += picture.view().at(x + i % 4, y + i / 4);
      to[static_cast<std::size_t>((top + y / 4) * width + left + x / 4)] = static_cast<std::uint8_t>(sum / 16);
    }
}

void save_recording(const std::string& folder, const std::string& only, std::size_t count) {
  const TrueLens lens = [&] {
    for (const TrueLens& one : lenses())
      if (only == one.name) return one;
    return lenses()[1];
  }();
  std::filesystem::create_directories(folder + "/frames");
  constexpr int kAcross = 4, kDown = 3, kGap = 6;
  const int width = kAcross * (lens.camera.width_px / 4 + kGap) - kGap;
  const int height = kDown * (lens.camera.height_px / 4 + kGap) - kGap;
  std::vector<std::uint8_t> small(static_cast<std::size_t>(width * height), 255);
  for (std::size_t i = 0; i < count; ++i) {
    const Picture picture =
        held_picture(lens.camera, held_pose(lens.camera, {}, 101, i), nine_dot_sheet(), random_bits(101, 1000 + i));
    const std::string path = fmt::format("{}/frames/{:06}.png", folder, i);
    if (!write_png_grey(path, picture.view())) fmt::print(stderr, "{}: can't be written\n", path);
    const int place = static_cast<int>(i);
    if (place < kAcross * kDown)
      put_small(picture, place % kAcross * (lens.camera.width_px / 4 + kGap),
                place / kAcross * (lens.camera.height_px / 4 + kGap), width, small);
  }
  if (!write_png_grey(folder + "/views.png", {small.data(), width, height, width}))
    fmt::print(stderr, "{}/views.png: can't be written\n", folder);
}

void run_recording(const std::string& folder) {
  const CameraModel truth = read_camera_file(folder + "/camera_true.yaml");
  const CalibrationTarget target = the_landmark();
  const std::unique_ptr<SheetFinder> finder = target.finder(usual_camera(truth.width_px, truth.height_px));
  const auto begun = Clock::now();
  const CollectedViews collected =
      collect_views(check_recordings({folder}), *finder, target.discs, [](const std::string&) { return true; });
  report(folder.substr(folder.find_last_of('/') + 1), "", truth, target, collected.views.views(),
         std::chrono::duration<double>(Clock::now() - begun).count());
}

}  // namespace
}  // namespace ninedot

int main(int argc, char** argv) {
  std::size_t views = 60;
  std::uint64_t seeds = 3;
  std::string only, save;
  std::vector<std::string> folders;
  bool outlines = false, grid = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--outlines" || word == "--grid") {
      (word == "--grid" ? grid : outlines) = true;
      continue;
    }
    if (!word.starts_with("--")) {
      folders.push_back(word);
      continue;
    }
    if (i + 1 == argc) break;
    const char* const value = argv[++i];
    if (word == "--views") views = std::strtoul(value, nullptr, 10);
    if (word == "--seeds") seeds = std::strtoul(value, nullptr, 10);
    if (word == "--lens") only = value;
    if (word == "--save") save = value;
  }
  if (!save.empty()) {
    ninedot::save_recording(save, only, views);
    return 0;
  }
  if (outlines) {
    ninedot::run_outlines(views, seeds, only);
    return 0;
  }
  ninedot::print_heading();
  for (const std::string& folder : folders) ninedot::run_recording(folder);
  if (folders.empty()) ninedot::run_rendered(grid ? ninedot::the_grid() : ninedot::the_landmark(), views, seeds, only);
  return 0;
}
