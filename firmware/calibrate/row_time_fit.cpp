#include "calibrate/row_time_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/contract.h"
#include "base/startup_error.h"
#include "geometry/sheet_motion.h"

namespace ninedot {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kLeastFrames = 20;
constexpr double kGap = 1.6;   // periods; above, one picture is missing and the motion between is not known
constexpr int kRounds = 30;    // 4 to 8 are taken
constexpr int kRowRounds = 6;  // each leaves a tenth of the error: the speed of a dot in rows per row
constexpr double kSettled_s = 1e-11;
constexpr double kOutlier = 9;        // times the median misfit: a mirror image, something before the sheet
constexpr double kMaxTurn_rad = 0.2;  // in one step: the equations are linear no further
constexpr int kBlocks = 10;

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWorkFailed, what); }

struct Frame {
  const MovingSighting* seen;
  DotSightings dots;          // as they were exposed
  CameraFromLandmark T;       // of the middle row
  std::size_t before, after;  // index of the frames that tell how it moves; itself at an end
  double weight = 1;          // 0: an outlier
};

/// One frame's equations, its pose eliminated.
struct RowSums {
  double gg = 0, gr = 0, chi2 = 0;
  int freedoms = 0;
  Vector6 from_residual = Vector6::Zero(), from_row_time = Vector6::Zero();  // of its pose's step
};

class Fitter {
 public:
  Fitter(std::span<const MovingSighting> sightings, const CameraModel& camera, const LandmarkGeometry& landmark,
         double longest_s, double useful_share)
      : camera_(camera),
        landmark_(landmark),
        longest_s_(longest_s),
        useful_share_(useful_share),
        middle_row_px_(0.5 * (camera.height_px - 1)) {
    std::vector<const MovingSighting*> sorted;
    for (const MovingSighting& sighting : sightings) sorted.push_back(&sighting);
    std::ranges::sort(sorted,
                      [](const auto* a, const auto* b) { return a->id != b->id ? a->id < b->id : a->at < b->at; });
    period_s_ = median_period_s(sorted);
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      const bool has_before = i > 0 && follows(*sorted[i - 1], *sorted[i]);
      const bool has_after = i + 1 < sorted.size() && follows(*sorted[i], *sorted[i + 1]);
      frames_.push_back({sorted[i], as_exposed(*sorted[i]), sorted[i]->T_camera_landmark, has_before ? i - 1 : i,
                         has_after ? i + 1 : i});
    }
  }

  RowTimeFit fit() {
    std::size_t usable = 0;
    for (const Frame& frame : frames_) usable += is_inner(frame);
    if (usable < kLeastFrames)
      refuse(fmt::format(
          "{} pictures show a landmark with two before and two after that do; {} are needed: record without gaps, with "
          "the landmark in view",
          usable, kLeastFrames));
    for (int round = 0; round < kRounds; ++round) {
      const double before_s = row_time_s_;
      step();
      if (round >= 2) leave_out_outliers();
      row_time_s_ = std::clamp(row_time_s_, -2 * longest_s_, 2 * longest_s_);
      if (round > 3 && std::abs(row_time_s_ - before_s) < kSettled_s) break;
    }
    return judged();
  }

 private:
  /// Two frames before it and two after it are there.
  bool is_inner(const Frame& frame) const {
    const auto i = static_cast<std::size_t>(&frame - frames_.data());
    return frame.before != i && frame.after != i && frames_[frame.before].before != frame.before &&
           frames_[frame.after].after != frame.after;
  }

  /// What the outlines' model does (outline_pixels.cpp), backwards: a dot moves by the same from each row to the next.
  DotSightings as_exposed(const MovingSighting& seen) const {
    const SheetMotion& motion = seen.taken_back_by;
    const CameraFromLandmark& T = seen.T_camera_landmark;
    DotSightings dots = seen.dots;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      if (dots[dot].information.isZero(0)) continue;
      const Eigen::Vector2d on_sheet_m = landmark_.centre_m(dot);
      const Eigen::Vector3d p_m = T * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
      const Eigen::Vector2d ray_per_row = motion.row_time_s * motion.ray_velocity(p_m, T.translation_m);
      const Eigen::Vector2d at_middle = dots[dot].ray;
      for (int i = 0; i < kRowRounds; ++i)  // the row depends on the place
        dots[dot].ray =
            at_middle + (camera_.pixel_from_normalised(dots[dot].ray).y() - motion.middle_row_px) * ray_per_row;
    }
    return dots;
  }

  static double median_period_s(const std::vector<const MovingSighting*>& sorted) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < sorted.size(); ++i)
      if (sorted[i]->id == sorted[i - 1]->id)
        steps.push_back(std::chrono::duration<double>(sorted[i]->at - sorted[i - 1]->at).count());
    if (steps.empty()) return 0;
    std::ranges::nth_element(steps, steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
    return steps[steps.size() / 2];
  }
  bool follows(const MovingSighting& a, const MovingSighting& b) const {
    const double step_s = std::chrono::duration<double>(b.at - a.at).count();
    return a.id == b.id && step_s > 0 && step_s < kGap * period_s_;
  }

  /// Over the time of one picture's rows.
  struct Way {
    SheetMotion motion;
    Eigen::Vector3d turn_rad_s2{0, 0, 0}, push_m_s2{0, 0, 0};  // camera frame
    /// What the motion may be off by, at the frame: a hand that sets off or stops between two pictures moves as no
    /// polynomial does.
    SheetMotion unevenness{};

    SheetMotion at(double time_s) const {
      SheetMotion then = motion;
      then.rotation_rad_s += time_s * turn_rad_s2;
      then.translation_m_s += time_s * push_m_s2;
      return then;
    }
    CameraFromLandmark after(const CameraFromLandmark& T, double time_s) const {
      return at(time_s / 2).after(T, time_s);
    }
  };

  SheetMotion motion_between(const Frame& a, const Frame& b) const {
    const double time_s = std::chrono::duration<double>(b.seen->at - a.seen->at).count();
    if (!(time_s > 0)) return {};
    return {log_so3(b.T.rotation * a.T.rotation.transpose()) / time_s, (b.T.translation_m - a.T.translation_m) / time_s,
            row_time_s_, middle_row_px_};
  }

  /// By two frames before and two after: differences of the fourth order. Those of the second miss 0.5 % of a swing of
  /// one a second at 35 Hz, and the row time with it; without the acceleration it is 1 % off at 45 us and 480 rows.
  Way way_of(const Frame& frame) const {
    const Frame &a = frames_[frame.before], &b = frames_[frame.after];
    Way way{motion_between(a, b)};
    if (!is_inner(frame)) return way;
    const SheetMotion wide = motion_between(frames_[a.before], frames_[b.after]);
    way.motion.rotation_rad_s += (way.motion.rotation_rad_s - wide.rotation_rad_s) / 3;
    way.motion.translation_m_s += (way.motion.translation_m_s - wide.translation_m_s) / 3;
    const SheetMotion earlier = motion_between(a, frame), later = motion_between(frame, b);
    const double half_s = std::chrono::duration<double>(b.seen->at - a.seen->at).count() / 2;
    way.turn_rad_s2 = (later.rotation_rad_s - earlier.rotation_rad_s) / half_s;
    way.push_m_s2 = (later.translation_m_s - earlier.translation_m_s) / half_s;
    const SheetMotion first = motion_between(frames_[a.before], a), last = motion_between(b, frames_[b.after]);
    way.unevenness.rotation_rad_s =
        (last.rotation_rad_s - first.rotation_rad_s - 3 * (later.rotation_rad_s - earlier.rotation_rad_s)) / 2;
    way.unevenness.translation_m_s =
        (last.translation_m_s - first.translation_m_s - 3 * (later.translation_m_s - earlier.translation_m_s)) / 2;
    return way;
  }

  RowSums sums_of(const Frame& frame) const {
    const Way way = way_of(frame);
    Matrix6 N = Matrix6::Zero();
    Vector6 by_residual = Vector6::Zero(), by_row_time = Vector6::Zero();
    RowSums sums;
    double uneven = 0, moved = 0;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      const DotSighting& seen = frame.dots[dot];
      if (seen.information.isZero(0)) continue;
      const double rows = camera_.pixel_from_normalised(seen.ray).y() - middle_row_px_;
      const CameraFromLandmark T = way.after(frame.T, rows * row_time_s_);
      const Eigen::Vector2d on_sheet_m = landmark_.centre_m(dot);
      const Eigen::Vector3d arm_m = T.rotation * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
      const Eigen::Vector3d p_m = arm_m + T.translation_m;
      if (!(p_m.z() > 1e-3)) continue;
      const Eigen::Vector2d ray = p_m.hnormalized();
      Eigen::Matrix<double, 2, 3> G;
      G << 1 / p_m.z(), 0, -ray.x() / p_m.z(), 0, 1 / p_m.z(), -ray.y() / p_m.z();
      Eigen::Matrix3d cross;
      cross << 0, -arm_m.z(), arm_m.y(), arm_m.z(), 0, -arm_m.x(), -arm_m.y(), arm_m.x(), 0;
      Eigen::Matrix<double, 2, 6> A;
      A << -G * cross, G;
      const Eigen::Vector2d g = rows * way.at(rows * row_time_s_).ray_velocity(p_m, T.translation_m);
      const Eigen::Vector2d r = ray - seen.ray;
      const Eigen::Matrix2d& W = seen.information;
      const Eigen::Vector2d off = rows * way.unevenness.ray_velocity(p_m, T.translation_m);
      uneven += off.dot(W * off), moved += g.dot(W * g);
      N += A.transpose() * W * A;
      by_residual += A.transpose() * W * r;
      by_row_time += A.transpose() * W * g;
      sums.gg += g.dot(W * g), sums.gr += g.dot(W * r), sums.chi2 += r.dot(W * r);
      sums.freedoms += 2;
    }
    sums.freedoms -= 6;
    const Eigen::LDLT<Matrix6> solver(N);
    if (sums.freedoms < 1 || solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return {};
    sums.from_residual = solver.solve(by_residual);
    sums.from_row_time = solver.solve(by_row_time);
    sums.gg -= by_row_time.dot(sums.from_row_time);
    sums.gr -= by_row_time.dot(sums.from_residual);
    sums.chi2 -= by_residual.dot(sums.from_residual);
    // Its row time is off by the same part as its motion, however plain its dots are.
    const double unsure_s2 = moved > 0 ? uneven / moved * row_time_s_ * row_time_s_ : 0;
    const double weight = 1 / (1 + sums.gg * unsure_s2);
    sums.gg *= weight, sums.gr *= weight;
    return sums;
  }

  /// Gauss and Newton's, of the row time and of all poses; how the sheets move follows from the poses afterwards.
  void step() {
    sums_.clear();
    double gg = 0, gr = 0;
    for (const Frame& frame : frames_) {
      sums_.push_back(sums_of(frame));
      if (!is_inner(frame)) continue;
      gg += frame.weight * sums_.back().gg;
      gr += frame.weight * sums_.back().gr;
    }
    const double change_s = gg > 0 ? -gr / gg : 0;
    row_time_s_ += change_s;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      Vector6 move = -(sums_[i].from_residual + sums_[i].from_row_time * change_s);
      if (const double turn_rad = move.head<3>().norm(); turn_rad > kMaxTurn_rad) move *= kMaxTurn_rad / turn_rad;
      CameraFromLandmark& T = frames_[i].T;
      T = {exp_so3(move.head<3>()) * T.rotation, T.translation_m + move.tail<3>()};
    }
  }

  void leave_out_outliers() {
    std::vector<double> misfits;
    for (std::size_t i = 0; i < frames_.size(); ++i)
      if (sums_[i].freedoms > 0) misfits.push_back(sums_[i].chi2 / sums_[i].freedoms);
    if (misfits.empty()) return;
    std::ranges::nth_element(misfits, misfits.begin() + static_cast<std::ptrdiff_t>(misfits.size() / 2));
    const double limit = kOutlier * misfits[misfits.size() / 2];
    for (std::size_t i = 0; i < frames_.size(); ++i)
      frames_[i].weight = sums_[i].freedoms > 0 && sums_[i].chi2 / sums_[i].freedoms <= limit ? 1 : 0;
  }

  double speed_px_s(const Frame& frame) const {
    const SheetMotion motion = way_of(frame).motion;
    return camera_.fy_px * motion.ray_velocity(frame.T.translation_m, frame.T.translation_m).norm();
  }

  RowTimeFit judged() const {
    RowTimeFit fit;
    fit.row_time_s = row_time_s_;
    std::array<double, kBlocks> block_gg{}, block_gr{};
    double gg = 0, gr = 0, chi2 = 0;
    int freedoms = 0;
    std::vector<double> speeds;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (!is_inner(frames_[i]) || frames_[i].weight == 0) continue;
      const std::size_t block = i * kBlocks / frames_.size();
      gg += sums_[i].gg, gr += sums_[i].gr, block_gg[block] += sums_[i].gg, block_gr[block] += sums_[i].gr;
      chi2 += sums_[i].chi2, freedoms += sums_[i].freedoms;
      speeds.push_back(speed_px_s(frames_[i]));
      ++fit.frames;
    }
    if (!(gg > 0) || fit.frames < kLeastFrames) refuse("the pictures contradict each other: is the landmark at rest?");
    std::ranges::sort(speeds);
    fit.fastest_px_s = speeds[speeds.size() * 9 / 10];
    fit.misfit = freedoms > 0 ? chi2 / freedoms : 1;
    double scatter = 0;  // the delete-one jackknife's variance, over stretches of time
    for (int block = 0; block < kBlocks; ++block) {
      const auto b = static_cast<std::size_t>(block);
      const double off_s = gg > block_gg[b] ? -(gr - block_gr[b]) / (gg - block_gg[b]) : longest_s_;
      scatter += off_s * off_s * (kBlocks - 1) / kBlocks;
    }
    fit.sigma_s = std::sqrt(std::max(std::max(1.0, fit.misfit) / gg, scatter));
    check(fit);
    return fit;
  }

  void check(const RowTimeFit& fit) const {
    const double useful_s = useful_share_ * longest_s_;
    if (fit.sigma_s > useful_s)
      refuse(
          fmt::format("the motion is too slow: the row time is known to {:.2g} us only, {:.2g} are needed; the "
                      "landmark moved by {:.0f} "
                      "px/s, move it {:.1f} times as fast, or come nearer so that it fills more of the picture",
                      1e6 * fit.sigma_s, 1e6 * useful_s, fit.fastest_px_s, fit.sigma_s / useful_s));
    if (fit.row_time_s < -3 * fit.sigma_s)
      refuse(
          fmt::format("the rows are read from the last to the first ({:.2f} us): the picture stands on its head; turn "
                      "it in the camera",
                      1e6 * fit.row_time_s));
    if (fit.row_time_s > longest_s_ + 3 * fit.sigma_s)
      refuse(
          fmt::format("{:.1f} us from row to row are more than a frame has time for ({:.1f} us): are the recording's "
                      "time stamps right?",
                      1e6 * fit.row_time_s, 1e6 * longest_s_));
  }

  const CameraModel& camera_;
  const LandmarkGeometry& landmark_;
  const double longest_s_, useful_share_;
  double middle_row_px_, period_s_ = 0, row_time_s_ = 0;
  std::vector<Frame> frames_;
  std::vector<RowSums> sums_;
};

}  // namespace

RowTimeFit fit_row_time(std::span<const MovingSighting> sightings, const CameraModel& camera,
                        const LandmarkGeometry& landmark, double longest_s, double useful_share) {
  EXPECTS(longest_s > 0);
  return Fitter(sightings, camera, landmark, longest_s, useful_share).fit();
}

}  // namespace ninedot
