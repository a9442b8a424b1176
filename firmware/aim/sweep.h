#pragma once
/// The search for a landmark: the way along which the head's picture passes over everything that it can reach.
///
/// Rows lie so that pictures of neighbouring ones overlap by a fifth; the head goes along them to and fro, without
/// stopping. It begins where the landmark was lost, along the row there, towards where that went; the rest in whichever
/// order takes the least time. Over, it begins anew with that row: a landmark hangs where it hung, and what hid it
/// goes.
#include <chrono>

#include "aim/aim_options.h"

namespace ninedot {

/// Memory: inside. Threads: one.
class Sweep {
 public:
  /// How often the head is told where to go, at least: a way-point may wait for so long.
  static constexpr std::chrono::milliseconds kTick{10};

  /// \param half_width_rad, half_height_rad  of what a picture shows beside its middle
  Sweep(const AimOptions& options, double half_width_rad, double half_height_rad) noexcept;

  /// \param from  where the head is \param drift_rad_per_s  at which the landmark went, as head angles; 0: unknown
  void begin(const HeadAngles& from, const HeadAngles& drift_rad_per_s) noexcept;

  /// Where the head is to go now.
  HeadAngles way_point() const noexcept { return way_point(plan_, next_); }
  /// It is there. After the last way-point: begins anew.
  void reached() noexcept;

  /// From begin() until everything within reach was in the picture, from rest.
  std::chrono::nanoseconds duration() const noexcept { return duration_; }
  /// The longest that may be, wherever it begins. What comes into view behind the head's back is shown within two.
  std::chrono::nanoseconds longest() const noexcept { return longest_; }

  int row_count() const noexcept { return row_count_; }
  const AimAxis& pan() const noexcept { return pan_; }    ///< the axis at the speed of the search
  const AimAxis& tilt() const noexcept { return tilt_; }  ///< likewise

 private:
  struct Plan {
    HeadAngles from;
    double side = 1;  // 1: first to the left end, -1: to the right end
    int first_row = 0;
    bool up_first = true;        // the rows above the first one come before those below
    bool finishes_last = false;  // what is left of the first row comes last
  };
  HeadAngles way_point(const Plan& plan, int index) const noexcept;
  int way_point_count(const Plan& plan) const noexcept;
  int row_of(const Plan& plan, int place) const noexcept;
  double row_rad(int row) const noexcept;
  double end_rad(double side) const noexcept { return side > 0 ? pan_.max_rad : pan_.min_rad; }
  double duration_s(const Plan& plan) const noexcept;
  int row_near(double tilt_rad) const noexcept;
  Plan best_plan(const HeadAngles& from, const HeadAngles& drift_rad_per_s, int first_row) const noexcept;
  Plan next_round() const noexcept;
  void start(const Plan& plan) noexcept;

  AimAxis pan_, tilt_;
  int row_count_ = 1;
  Plan plan_;
  int next_ = 0;
  std::chrono::nanoseconds duration_{}, longest_{};
};

}  // namespace ninedot
