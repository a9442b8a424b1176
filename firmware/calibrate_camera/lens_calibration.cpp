// From coarse to fine: outlines where homographies expect them; a focal length, all poses with it, everything together
// with a loose floor on the outlines' sigmas; outlines again where the lens expects them; and the floor that they need.
#include "calibrate_camera/lens_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "calibrate_camera/edge_points.h"
#include "calibrate_camera/lens_parameters.h"
#include "calibrate_camera/lens_start.h"
#include "calibrate_camera/model_choice.h"
#include "calibrate_camera/sheet_map.h"

namespace ninedot {
namespace {

/// Outlines are taken to be off by so much while the lens is rough.
constexpr double kRoughFloor_px = 1;
/// Focal lengths to try beside Zhang's, in widths of the picture: from a fisheye to a tele lens.
constexpr double kFocalStarts[] = {0.35, 0.6, 1, 1.7, 3, 6};
/// Starts are compared on so many views at most.
constexpr std::size_t kStartViews = 12;
/// A view whose median outline is off by so many times what is usual, and by more than a tenth of a pixel, is of
/// something else: a sheet that was bent or moved, another sheet.
constexpr double kOutlierTimes = 5, kOutlier_px = 0.1;

class Calibrator {
 public:
  Calibrator(std::span<const PlaneDisc> discs, std::vector<SheetView> views, const LensCalibrationOptions& options)
      : discs_(discs), views_(std::move(views)), options_(options), given_(views_.size()) {
    if (options.go_on) adjust_options_.go_on = [this] { return goes_on("lens and views together"); };
  }

  std::optional<LensCalibration> run() {
    measure_by_homographies();
    if (views_.size() < 3) return std::nullopt;
    std::optional<LensFit> fit = rough_fit();
    if (!fit) return std::nullopt;
    measure_by_lens(*fit);
    refine(*fit);
    LensCalibration result;
    if (options_.rough) {
      result.fit = std::move(*fit);
      return result;
    }
    fit = chosen_model(*fit, result.tried);
    if (!fit || stopped_) return std::nullopt;
    measure_by_lens(*fit);
    refine(*fit);
    result.contradicting = drop_outliers(*fit);
    if (!refine(*fit)) return std::nullopt;
    result.left_out = static_cast<int>(given_ - views_.size());
    result.covariance = lens_covariance(discs_, views_, *fit);
    result.directions = direction_errors(fit->camera, result.covariance.matrix);
    result.rms_px = rms_px(*fit);
    result.fit = std::move(*fit);
    result.views = std::move(views_);
    return result;
  }

 private:
  bool goes_on(std::string_view what) {
    if (options_.go_on && !options_.go_on(what)) stopped_ = true;
    return !stopped_;
  }

  void measure_by_homographies() {
    for (SheetView& view : views_) {
      if (!goes_on("outlines")) return;
      view.edges = measure_edges(view, expected_by_homography(view, discs_), discs_).edges;
    }
    std::erase_if(views_, [](const SheetView& view) { return view.edges.size() < kLeastEdges; });
  }

  /// Where the lens shows each disc: those that were found moved to where they are seen, so that a lens that fits badly
  /// loses none; the others as they are, for what the picture's border leaves of them.
  void measure_by_lens(const LensFit& fit) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      SheetView& view = views_[i];
      const CameraFromLandmark& T = fit.views[i].T_camera_sheet;
      const SheetMap map = map_of_camera(fit.camera, T);
      std::vector<ExpectedDisc> expected;
      for (std::size_t disc = 0; disc < discs_.size(); ++disc) {
        const auto seen = std::ranges::find(view.seen, disc, &SeenDisc::disc);
        const Eigen::Vector2d ray = project_disc_centre(T, discs_[disc].centre_m, discs_[disc].radius_m);
        const Eigen::Vector2d shift_px =
            seen != view.seen.end() ? seen->centre_px - fit.camera.pixel_from_normalised(ray) : Eigen::Vector2d(0, 0);
        expected.push_back({disc, [map, shift_px](const Eigen::Vector2d& plane_m) -> Eigen::Vector2d {
                              return map(plane_m) + shift_px;
                            }});
      }
      std::vector<EdgePoint> edges = measure_edges(view, expected, discs_).edges;
      if (edges.size() >= kLeastEdges) view.edges = std::move(edges);
    }
  }

  CameraModel plain_camera(double focal_px, DistortionModel model) const {
    CameraModel camera;
    camera.width_px = options_.width_px, camera.height_px = options_.height_px;
    camera.fx_px = camera.fy_px = focal_px;
    camera.cx_px = 0.5 * (options_.width_px - 1), camera.cy_px = 0.5 * (options_.height_px - 1);
    camera.model = model;
    return camera;
  }

  /// The sheets before a lens that is taken as known. \return  infinite loss: a view fits nowhere
  LensFit with_poses(const CameraModel& camera, std::size_t every) const {
    LensFit fit{camera, std::vector<ViewState>(views_.size()), kRoughFloor_px, 0};
    for (std::size_t i = 0; i < views_.size(); i += every) {
      const std::optional<ViewFit> view = fit_view(camera, discs_, views_[i], kRoughFloor_px);
      // A view that fits nowhere counts as one whose outlines are all a hundred sigmas off.
      fit.loss += view ? view->loss : 25 * static_cast<double>(views_[i].edges.size());
      if (view) fit.views[i] = view->state;
    }
    return fit;
  }

  std::optional<LensFit> rough_fit() {
    std::vector<CameraModel> starts;
    std::vector<DistortionModel> models{DistortionModel::kPlumbBob, DistortionModel::kEquidistant};
    if (options_.model) models = {*options_.model};
    for (const DistortionModel model : models) {
      if (const auto focal_px = focal_from_homographies(views_, discs_, options_.width_px, options_.height_px))
        starts.push_back(plain_camera(*focal_px, model));
      for (const double widths : kFocalStarts) starts.push_back(plain_camera(widths * options_.width_px, model));
    }
    if (options_.guess && (!options_.model || options_.guess->model == *options_.model))
      starts.push_back(*options_.guess);
    std::vector<LensFit> fits;
    const std::size_t every = 1 + views_.size() / kStartViews;
    for (const CameraModel& start : starts) {
      if (!goes_on("focal length")) return std::nullopt;
      fits.push_back(with_poses(start, every));
    }
    std::ranges::sort(fits, {}, &LensFit::loss);
    // The best two go on: a lens that bends much may look like another focal length.
    std::optional<LensFit> best;
    for (std::size_t i = 0; i < std::min<std::size_t>(2, fits.size()); ++i) {
      LensFit fit = with_poses(fits[i].camera, 1);
      if (!drop_unfit_and_adjust(fit)) continue;
      if (!best || fit.loss < best->loss) best = std::move(fit);
    }
    return best;
  }

  /// Everything together, then each view again from both planar poses: a lens that was rough may have chosen the wrong
  /// one.
  bool drop_unfit_and_adjust(LensFit& fit) {
    for (int round = 0; round < 2; ++round) {
      if (!adjust_lens(discs_, views_, fit, adjust_options_)) return false;
      refit_views(fit);
    }
    return adjust_lens(discs_, views_, fit, adjust_options_);
  }

  void refit_views(LensFit& fit) const {
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (const auto view = fit_view(fit.camera, discs_, views_[i], fit.floor_px, &fit.views[i]))
        fit.views[i] = view->state;
  }

  /// The floor that the outlines need, and the fit that belongs to it.
  bool refine(LensFit& fit) {
    for (int round = 0; round < 3; ++round) {
      fit.floor_px = unexplained_px(discs_, views_, fit);
      refit_views(fit);
      if (!adjust_lens(discs_, views_, fit, adjust_options_)) return false;
    }
    return true;
  }

  std::optional<LensFit> chosen_model(const LensFit& fit, std::vector<TriedModel>& tried) {
    if (options_.model) return fit;
    ModelChoiceOptions choice{adjust_options_, [this](std::string_view what) { return goes_on(what); }};
    return choose_model(discs_, views_, fit, choice, tried);
  }

  /// \return  how many
  int drop_outliers(LensFit& fit) {
    std::vector<double> medians_px;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      std::vector<double> off_px = edge_residuals_px(fit.camera, discs_, views_[i], fit.views[i]);
      for (double& px : off_px) px = std::isfinite(px) ? std::abs(px) : std::numeric_limits<double>::infinity();
      medians_px.push_back(median(std::move(off_px)));
    }
    const double limit_px = std::max(kOutlier_px, kOutlierTimes * median(medians_px));
    std::size_t kept = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (medians_px[i] > limit_px) continue;
      if (kept != i) views_[kept] = std::move(views_[i]), fit.views[kept] = fit.views[i];
      ++kept;
    }
    const auto dropped = static_cast<int>(views_.size() - kept);
    views_.resize(kept), fit.views.resize(kept);
    return dropped;
  }

  double rms_px(const LensFit& fit) const {
    double squares = 0, weights = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const std::vector<double> off_px = edge_residuals_px(fit.camera, discs_, views_[i], fit.views[i]);
      for (std::size_t e = 0; e < off_px.size(); ++e) {
        const double sigma_px = total_sigma_px(views_[i].edges[e], fit.floor_px);
        if (!std::isfinite(off_px[e]) || std::abs(off_px[e]) > 5 * sigma_px) continue;
        squares += off_px[e] * off_px[e] / (sigma_px * sigma_px), weights += 1 / (sigma_px * sigma_px);
      }
    }
    return weights > 0 ? std::sqrt(squares / weights) : 0;
  }

  static double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }

  std::span<const PlaneDisc> discs_;
  std::vector<SheetView> views_;
  const LensCalibrationOptions& options_;
  std::size_t given_;
  AdjustLensOptions adjust_options_;
  bool stopped_ = false;
};

}  // namespace

std::optional<LensCalibration> calibrate_lens(std::span<const PlaneDisc> discs, std::vector<SheetView> views,
                                              const LensCalibrationOptions& options) {
  return Calibrator(discs, std::move(views), options).run();
}

std::string_view name_of(DistortionModel model) noexcept {
  if (model == DistortionModel::kRationalPolynomial) return "rational_polynomial";
  return model == DistortionModel::kEquidistant ? "equidistant" : "plumb_bob";
}

}  // namespace ninedot
