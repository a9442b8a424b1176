// A blurred disc's outline is seen further in than it is: points of half the contrast move against the curvature by
// blur^2 / (2 radius), to first order as in curvature flow. That is taken back. What a tone curve moves is the same for
// all outlines of a view to first order, and an unknown of the fit (lens_adjustment.h).
#include "calibrate_camera/edge_points.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace ninedot {
namespace {

/// Stretches of about so many pixels along the outline: some 60 pixels of the picture each.
constexpr double kStretch_px = 10;
constexpr int kMinStretches = 8, kMaxStretches = 40;
/// Pixels within this of the outline are looked at; beside a small dot less, so that white is left beyond them.
constexpr double kBand_px = 4, kBand_radii = 0.7;
/// Across the narrow axis; below it there are too few pixels of plain ink and paper beside the step.
constexpr double kSmallest_px = 3.5;
/// The rendered and recorded pictures' blur, pixel included, is 0.5 to 1.5 px.
constexpr double kUsualBlur_px = 0.7, kMinBlur_px = 0.3, kMaxBlur_px = 3;
constexpr double kMinContrast_lsb = 15, kMinContrast_sigmas = 6;
/// What a stretch's pixels may differ from the step by: this many times the noise and this part of the contrast, for
/// light that changes along it and tone curves that bend the step. A shadow's edge leaves an eighth and more.
constexpr double kMisfit_sigmas = 2, kMisfit_share = 0.035;
/// A shift beyond it is another edge's. [px]
constexpr double kMaxShift_px = 2.5;
/// Colour interpolation and sharpening make up what they need beyond the picture's border: two pixels of 5 x 5. One
/// more is grey_lsb_at's.
constexpr int kBorder_px = 3;
/// A grey level is rounded: 1 / sqrt(12).
constexpr double kRounding_lsb = 0.289;
constexpr int kSteps = 8;

/// One stretch: its middle on the outline, and its pixels.
struct Stretch {
  std::size_t disc = 0;
  Eigen::Vector2d middle_px, normal;  ///< outwards
  double curvature_per_px = 0;
  std::vector<std::array<double, 2>> pixels;  ///< distance from the outline, outside positive [px]; grey level [LSB]
};

struct Step {
  double ink_lsb = 0, contrast_lsb = 0, shift_px = 0, blur_px = kUsualBlur_px;
  double sigma_px = 0;  ///< of the shift
  double rms_lsb = 0;
};

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }
double normal_density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi); }

/// Gauss and Newton's method. \param free_blur  the blur is an unknown, else it is `start`'s
std::optional<Step> fit_step(const Stretch& stretch, Step start, bool free_blur, const PictureNoise& noise) {
  if (stretch.pixels.size() < 10) return std::nullopt;
  const int unknowns = free_blur ? 4 : 3;
  Eigen::Matrix4d N;
  Eigen::Vector4d g;
  for (int step = 0; step < kSteps; ++step) {
    N.setZero(), g.setZero();
    double squares = 0;
    for (const auto& [distance_px, grey_lsb] : stretch.pixels) {
      const double z = (distance_px - start.shift_px) / start.blur_px;
      const double rise = normal_cdf(z), slope = start.contrast_lsb * normal_density(z) / start.blur_px;
      const Eigen::Vector4d J(1, rise, -slope, -slope * z);
      const double residual = grey_lsb - start.ink_lsb - start.contrast_lsb * rise;
      N += J * J.transpose(), g += J * residual, squares += residual * residual;
    }
    start.rms_lsb = std::sqrt(squares / std::max<double>(1, static_cast<double>(stretch.pixels.size()) - unknowns));
    if (!free_blur) N.row(3).setZero(), N.col(3).setZero(), N(3, 3) = 1, g(3) = 0;
    const Eigen::LDLT<Eigen::Matrix4d> solver(N);
    const Eigen::Vector4d move = solver.solve(g);
    if (!move.allFinite()) return std::nullopt;
    const double lsb = std::max({noise.at(start.ink_lsb + start.contrast_lsb / 2), kRounding_lsb, start.rms_lsb});
    start.sigma_px = lsb * std::sqrt(std::max(0.0, solver.solve(Eigen::Vector4d::UnitZ())(2)));
    start.ink_lsb += move(0), start.contrast_lsb += move(1);
    start.shift_px += std::clamp(move(2), -1.0, 1.0);
    start.blur_px = std::clamp(start.blur_px + std::clamp(move(3), -0.3, 0.3), kMinBlur_px, kMaxBlur_px);
    if (std::abs(start.shift_px) > kMaxShift_px) return std::nullopt;
  }
  const double lsb = std::max(noise.at(start.ink_lsb + start.contrast_lsb / 2), kRounding_lsb);
  const bool is_outline = start.contrast_lsb > kMinContrast_lsb && start.contrast_lsb > kMinContrast_sigmas * lsb &&
                          start.rms_lsb < kMisfit_sigmas * lsb + kMisfit_share * start.contrast_lsb;
  return is_outline ? std::optional(start) : std::nullopt;
}

/// Ink and paper as the extremes of the pixels; where the step is, fit_step finds.
Step start_of(const Stretch& stretch) {
  Step start;
  double inside = 0, outside = 0, insides = 0, outsides = 0;
  for (const auto& [distance_px, grey_lsb] : stretch.pixels) {
    if (distance_px < -1) inside += grey_lsb, ++insides;
    if (distance_px > 1) outside += grey_lsb, ++outsides;
  }
  start.ink_lsb = insides > 0 ? inside / insides : 0;
  start.contrast_lsb = outsides > 0 ? outside / outsides - start.ink_lsb : 0;
  return start;
}

/// Of a colour sensor the mean of 3 x 3 pixels with binomial weights, which takes out whatever has a period of two
/// pixels. The colours of a Bayer pattern are sampled every other pixel: where they are interpolated an edge is sharp
/// in one pixel and blurred in the next, and what is left of that in luma moves an edge that runs along the pattern by
/// a few hundredths of a pixel. Others are left as they are: a wider step errs more where an outline bends.
double grey_lsb_at(const ImageView& luma, SensorKind sensor, int x, int y) {
  if (sensor == SensorKind::kGrey) return luma.at(x, y);
  const auto across = [&](int row) { return luma.at(x - 1, row) + 2 * luma.at(x, row) + luma.at(x + 1, row); };
  return (across(y - 1) + 2 * across(y) + across(y + 1)) / 16.0;
}

/// Pixels beside a stretch of the outline, which is taken as an arc of a circle.
/// \return  false where it reaches out of the picture
bool collect_pixels(const PictureCrop& picture, double half_length_px, double band_px, Stretch& stretch) {
  const double radius_px = 1 / std::max(stretch.curvature_per_px, 1e-6);
  const Eigen::Vector2d centre = stretch.middle_px - radius_px * stretch.normal;
  const Eigen::Vector2d along(-stretch.normal.y(), stretch.normal.x());
  const double reach_px = std::hypot(half_length_px, band_px) + 1;
  const Eigen::Vector2d at = stretch.middle_px - Eigen::Vector2d(picture.left_px, picture.top_px);
  const int x0 = static_cast<int>(std::ceil(at.x() - reach_px)), x1 = static_cast<int>(std::floor(at.x() + reach_px));
  const int y0 = static_cast<int>(std::ceil(at.y() - reach_px)), y1 = static_cast<int>(std::floor(at.y() + reach_px));
  const ImageView luma = picture.view();
  if (!luma.contains(x0 - kBorder_px, y0 - kBorder_px) || !luma.contains(x1 + kBorder_px, y1 + kBorder_px))
    return false;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d from_centre = Eigen::Vector2d(x + picture.left_px, y + picture.top_px) - centre;
      const double distance_px = from_centre.norm() - radius_px;
      const double turn = std::atan2(along.dot(from_centre), stretch.normal.dot(from_centre));
      if (std::abs(distance_px) > band_px || std::abs(turn) * radius_px > half_length_px) continue;
      stretch.pixels.push_back({distance_px, grey_lsb_at(luma, picture.sensor, x, y)});
    }
  return true;
}

/// Circumference and narrow half axis of an outline in the picture.
struct OutlineSize {
  double length_px = 0, narrow_px = 0;
};

OutlineSize size_of(const SheetMap& map, const PlaneDisc& disc) {
  Eigen::Matrix2d J;  // px per radius
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step_m = disc.radius_m * Eigen::Vector2d::Unit(axis);
    J.col(axis) = (map(disc.centre_m + step_m) - map(disc.centre_m - step_m)) / 2;
  }
  const Eigen::Vector2d axes = J.jacobiSvd().singularValues();
  return {std::numbers::pi * (axes(0) + axes(1)), axes(1)};
}

void add_stretches(const SheetView& view, const SheetMap& map, std::size_t disc_index, const PlaneDisc& disc,
                   std::vector<Stretch>& stretches) {
  const OutlineSize size = size_of(map, disc);
  if (!(size.narrow_px >= kSmallest_px) || !std::isfinite(size.length_px)) return;
  const int count = std::clamp(static_cast<int>(size.length_px / kStretch_px), kMinStretches, kMaxStretches);
  const double band_px = std::min(kBand_px, kBand_radii * size.narrow_px), turn = 2 * std::numbers::pi / count;
  const auto outline = [&](double angle) {
    return map(disc.centre_m + disc.radius_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  };
  const Eigen::Vector2d middle = map(disc.centre_m);
  for (int i = 0; i < count; ++i) {
    // Curvature from three points a quarter of a stretch apart.
    const double angle = turn * i, h = turn / 4;
    const Eigen::Vector2d before = outline(angle - h), at = outline(angle), after = outline(angle + h);
    const Eigen::Vector2d first = (after - before) / (2 * h), second = (after - 2 * at + before) / (h * h);
    Stretch stretch;
    stretch.disc = disc_index;
    stretch.middle_px = at;
    stretch.normal = Eigen::Vector2d(first.y(), -first.x()).normalized();
    if (stretch.normal.dot(at - middle) < 0) stretch.normal = -stretch.normal;
    stretch.curvature_per_px = -second.dot(stretch.normal) / first.squaredNorm();
    const double half_length_px =
        std::min(first.norm() * turn / 2, kStretch_px);  // where the lens folds back, no endless one
    if (!stretch.normal.allFinite() || !std::isfinite(stretch.curvature_per_px)) continue;
    if (collect_pixels(view.picture, half_length_px, band_px, stretch)) stretches.push_back(std::move(stretch));
  }
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

MeasuredOutlines measure_edges(const SheetView& view, std::span<const ExpectedDisc> expected,
                               std::span<const PlaneDisc> discs) {
  std::vector<Stretch> stretches;
  for (const ExpectedDisc& one : expected) add_stretches(view, one.map, one.disc, discs[one.disc], stretches);
  std::vector<double> blurs_px;
  for (const Stretch& stretch : stretches)
    if (const std::optional<Step> step = fit_step(stretch, start_of(stretch), true, view.noise))
      blurs_px.push_back(step->blur_px);
  if (blurs_px.empty()) return {};
  const double blur_px = median(std::move(blurs_px));
  MeasuredOutlines outlines{{}, blur_px};
  for (const Stretch& stretch : stretches) {
    Step start = start_of(stretch);
    start.blur_px = blur_px;
    const std::optional<Step> step = fit_step(stretch, start, false, view.noise);
    if (!step) continue;
    const double inwards_px = blur_px * blur_px * stretch.curvature_per_px / 2;
    outlines.edges.push_back(
        {stretch.disc, stretch.middle_px + (step->shift_px + inwards_px) * stretch.normal, step->sigma_px});
  }
  return outlines;
}

std::vector<ExpectedDisc> expected_by_homography(const SheetView& view, std::span<const PlaneDisc> discs) {
  std::vector<ExpectedDisc> expected;
  Eigen::Matrix3d H;
  if (!fit_sheet_map(view.seen, discs, H)) return expected;
  for (const SeenDisc& seen : view.seen)
    expected.push_back({seen.disc, map_of_disc(H, discs[seen.disc], seen.centre_px)});
  return expected;
}

}  // namespace ninedot
