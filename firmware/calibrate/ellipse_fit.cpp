#include "calibrate/ellipse_fit.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/contract.h"
#include "base/startup_error.h"
#include "pose/ellipse_distance.h"
#include "pose/ring_ellipse.h"

namespace ninedot {
namespace {

constexpr std::size_t kLeastDistances = 4;  // three unknowns, and one to contradict them
constexpr double kDistinct = 0.05;          // distances that differ by less are one [1]
/// A centred shot's P9 lies within this share of the picture's width of its middle: the literal formulas err by some
/// 1e-3 of the distance there (docs/method-ellipse.md); an off-centre one's lies beyond it.
constexpr double kCentred = 0.05;
/// The literal formulas err by up to 4 % at 0.3 m and 75 degrees (docs/method-ellipse.md); more is a wrong distance.
constexpr double kContradicts = 0.05;
constexpr double kSteepest = 4, kStep = 0.05, kFlattest = 0.2;  // p3 [1]
/// 1-sigma of a ring's semi-axis, with what noise adds to the larger one of two, and of a distance by tape measure:
/// they say how much each shot counts, the near ones being seen best and the far ones measured best.
constexpr double kAxisSigma_px = 0.05, kTapeSigma_mm = 1;
/// A law of the distance must explain the shots so much better that chance would do so this rarely.
constexpr double kByChance = 0.01;

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWorkFailed, what); }

/// A centred shot, in the solver's own terms.
struct Ring {
  std::uint64_t frame;
  double distance_mm, semi_major_px;

  /// Of what it says of F, relative.
  double weight() const noexcept {
    return 1 / (std::pow(kAxisSigma_px / semi_major_px, 2) + std::pow(kTapeSigma_mm / distance_mm, 2));
  }
};

/// What F of 2 and so many freedoms exceeds by chance (its distribution has a closed form for 2).
double worth_it(double freedoms) noexcept { return freedoms / 2 * (std::pow(kByChance, -2 / freedoms) - 1); }

class Fitter {
 public:
  Fitter(std::span<const EllipseShot> shots, const CameraModel& camera, const LandmarkGeometry& landmark,
         double focal_length_mm)
      : shots_(shots), camera_(camera), radius_mm_(1000 * landmark.ring_radius_m), focal_mm_(focal_length_mm) {}

  EllipseFit fit() {
    for (const EllipseShot& shot : shots_) check_shot(shot);
    for (const EllipseShot& shot : shots_)
      if (!shot.centred_frame) rings_.push_back({shot.frame, 1000 * shot.distance_m, semi_major_px(shot)});
    std::ranges::sort(rings_, {}, &Ring::distance_mm);
    check_distances();
    EllipseFit fit;
    fit.centred = rings_.size();
    fit.off_centre = shots_.size() - rings_.size();
    EllipseCalibration& c = fit.calibration;
    for (const Ring& ring : rings_)
      c.kmm_mm_per_px += focal_mm_ * radius_mm_ / (ring.distance_mm * ring.semi_major_px) /
                         static_cast<double>(rings_.size());  // (7); D' - f = D
    fit_distances(fit);
    judge(fit);
    if (fit.off_centre > 0) fit_off_centre(c);
    return fit;
  }

 private:
  Eigen::Vector2d p9_px(const EllipseShot& shot) const {
    return camera_.fx_px * shot.sight.outline_centres[kCentreDot];
  }

  void check_shot(const EllipseShot& shot) const {
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      if (!shot.sight.seen[dot])
        refuse(
            fmt::format("frame {}: P{} is hidden; a shot for a calibration shows all nine dots", shot.frame, dot + 1));
    const double off_px = p9_px(shot).norm(), limit_px = kCentred * camera_.width_px;
    if (!shot.centred_frame && off_px > limit_px)
      refuse(
          fmt::format("frame {}: P9 is {:.0f} px from the optical axis, which is too far for a centred shot: bring it "
                      "within {:.0f} px, or say of which centred frame it is the off-centre shot",
                      shot.frame, off_px, limit_px));
    if (shot.centred_frame && off_px <= limit_px)
      refuse(
          fmt::format("frame {}: P9 is {:.0f} px from the optical axis, which is too near for an off-centre shot: "
                      "turn the camera until it is beyond {:.0f} px",
                      shot.frame, off_px, limit_px));
  }

  double semi_major_px(const EllipseShot& shot) const {
    std::array<Eigen::Vector2d, kRingDotCount> points;
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot)
      points[dot] = camera_.fx_px * shot.sight.outline_centres[dot] - p9_px(shot);
    const Result<RingEllipse> ellipse = fit_ring_ellipse(points);
    if (!ellipse) refuse(fmt::format("frame {}: {}", shot.frame, ellipse.error().text));
    return ellipse->semi_major;
  }

  /// The ring grows as the distance shrinks: D a is one number for all, but for what F corrects.
  void check_distances() const {
    std::size_t distinct = rings_.empty() ? 0 : 1;
    double last_mm = rings_.empty() ? 0 : rings_.front().distance_mm;
    std::vector<double> products;
    for (const Ring& ring : rings_) {
      products.push_back(ring.distance_mm * ring.semi_major_px);
      if (ring.distance_mm <= last_mm * (1 + kDistinct)) continue;
      ++distinct;
      last_mm = ring.distance_mm;
    }
    if (distinct < kLeastDistances)
      refuse(
          fmt::format("there are centred shots at {} distances; {} are needed, each {:.0f} % further than the one "
                      "before",
                      distinct, kLeastDistances, 100 * kDistinct));
    for (std::size_t i = 1; i < rings_.size(); ++i)
      if (rings_[i].semi_major_px > rings_[i - 1].semi_major_px * (1 + kContradicts))
        refuse(
            fmt::format("frame {} is said to be at {:g} mm, but shows a larger ring than frame {} at {:g} mm: are the "
                        "distances in the order of the frames?",
                        rings_[i].frame, rings_[i].distance_mm, rings_[i - 1].frame, rings_[i - 1].distance_mm));
    std::vector<double> sorted = products;
    std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
    const double median = sorted[sorted.size() / 2];
    for (std::size_t i = 0; i < rings_.size(); ++i)
      if (std::abs(products[i] / median - 1) > kContradicts)
        refuse(
            fmt::format("frame {} is said to be at {:g} mm, but by the other shots it is at about {:.0f} mm: measure "
                        "again, from P9 to the lens",
                        rings_[i].frame, rings_[i].distance_mm, median / rings_[i].semi_major_px));
  }

  struct Law {
    double p1 = 0, p2 = 0, p3 = 0, squares = 0;
  };

  /// F relative to Kmm, and the distance relative to the median one, so that the equations are well scaled.
  Law law_of(double p3, double kmm, double f_mm) const {
    const double at_mm = rings_[rings_.size() / 2].distance_mm + f_mm;
    Eigen::Matrix2d N = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    const auto row = [&](const Ring& ring) {
      return Eigen::Vector2d(1, p3 == 0 ? 0 : std::pow((ring.distance_mm + f_mm) / at_mm, p3));
    };
    const auto wanted = [&](const Ring& ring) {
      return f_mm * radius_mm_ / (ring.semi_major_px * ring.distance_mm * kmm);
    };
    for (const Ring& ring : rings_) {
      N += ring.weight() * row(ring) * row(ring).transpose();
      b += ring.weight() * row(ring) * wanted(ring);
    }
    if (p3 == 0) N(1, 1) = 1;
    const Eigen::Vector2d p = N.inverse() * b;
    Law law{p[0] * kmm, p3 == 0 ? 0 : p[1] * kmm / std::pow(at_mm, p3), p3, 0};
    for (const Ring& ring : rings_) law.squares += ring.weight() * std::pow(row(ring).dot(p) - wanted(ring), 2);
    if (!p.allFinite()) law.squares = std::numeric_limits<double>::infinity();
    return law;
  }

  void fit_distances(EllipseFit& fit) const {
    EllipseCalibration& c = fit.calibration;
    const double f_mm = camera_.fx_px * c.kmm_mm_per_px;
    const Law constant = law_of(0, c.kmm_mm_per_px, f_mm);
    Law best{0, 0, 0, std::numeric_limits<double>::infinity()};
    const auto consider = [&](double p3) {
      if (std::abs(p3) < kFlattest) return;
      if (const Law law = law_of(p3, c.kmm_mm_per_px, f_mm); law.squares < best.squares) best = law;
    };
    for (double p3 = -kSteepest; p3 <= kSteepest; p3 += kStep) consider(p3);
    for (double step = kStep / 2, around = best.p3; step > 1e-7; step /= 2, around = best.p3)
      consider(around - step), consider(around + step);
    const double freedoms = static_cast<double>(rings_.size()) - 3;
    // Nobody measures a thousand times better: what is below that is no law.
    const double noise = best.squares / freedoms + 1e-6;
    fit.depends_on_distance = (constant.squares - best.squares) / 2 > worth_it(freedoms) * noise;
    const Law& law = fit.depends_on_distance ? best : constant;
    c.p1 = law.p1, c.p2 = law.p2, c.p3 = law.p3;
  }

  /// By the solver's own iteration.
  void judge(EllipseFit& fit) const {
    const EllipseCalibration& c = fit.calibration;
    const DistanceScale scale{camera_.fx_px * c.kmm_mm_per_px, c.kmm_mm_per_px, c.p1, c.p2, c.p3};
    for (const Ring& ring : rings_) {
      const Result<double> image_mm = image_distance_mm(ring.semi_major_px, radius_mm_, scale);
      if (!image_mm)
        refuse(
            fmt::format("frame {}: the distance refinement does not settle with what the shots give: take more shots, "
                        "and none nearer than four times the ring's radius",
                        ring.frame));
      const double off = std::abs((*image_mm - scale.focal_length_mm) / ring.distance_mm - 1);
      fit.rms_share += off * off / static_cast<double>(rings_.size());
      fit.worst_share = std::max(fit.worst_share, off);
    }
    fit.rms_share = std::sqrt(fit.rms_share);
  }

  const EllipseShot& centred_of(const EllipseShot& shot) const {
    const auto found = std::ranges::find(shots_, *shot.centred_frame, &EllipseShot::frame);
    if (found == shots_.end() || found->centred_frame)
      refuse(fmt::format("frame {}: its centred frame {} is not among the centred shots", shot.frame,
                         *shot.centred_frame));
    if (std::abs(found->distance_m / shot.distance_m - 1) > kDistinct)
      refuse(fmt::format("frame {} at {:g} mm and its centred frame {} at {:g} mm: both are taken from one place",
                         shot.frame, 1000 * shot.distance_m, found->frame, 1000 * found->distance_m));
    return *found;
  }

  /// du0 = (1 + cu (u9^2 + u9^4)) du: linear in cu; the same for v.
  void fit_off_centre(EllipseCalibration& c) const {
    Eigen::Vector2d top = Eigen::Vector2d::Zero(), bottom = top;
    for (const EllipseShot& shot : shots_) {
      if (!shot.centred_frame) continue;
      const EllipseShot& centred = centred_of(shot);
      const Eigen::Array2d squares = p9_px(shot).array().square();
      const Eigen::Array2d reach = squares + squares.square();
      for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
        const Eigen::Array2d seen = camera_.fx_px * shot.sight.outline_centres[dot] - p9_px(shot);
        const Eigen::Array2d wanted = camera_.fx_px * centred.sight.outline_centres[dot] - p9_px(centred);
        top.array() += reach * seen * (wanted - seen);
        bottom.array() += (reach * seen).square();
      }
    }
    // Shots that are off along one axis only say nothing of the other.
    const double least = std::pow(std::pow(kCentred * camera_.width_px, 4) * 10, 2);
    c.cu = bottom.x() > least ? top.x() / bottom.x() : 0;
    c.cv = bottom.y() > least ? top.y() / bottom.y() : 0;
  }

  std::span<const EllipseShot> shots_;
  const CameraModel& camera_;
  double radius_mm_, focal_mm_;
  std::vector<Ring> rings_;  // by distance
};

}  // namespace

EllipseFit fit_ellipse_calibration(std::span<const EllipseShot> shots, const CameraModel& camera,
                                   const LandmarkGeometry& landmark, double focal_length_mm) {
  EXPECTS(focal_length_mm > 0);
  return Fitter(shots, camera, landmark, focal_length_mm).fit();
}

}  // namespace ninedot
