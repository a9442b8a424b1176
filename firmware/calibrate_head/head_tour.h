#pragma once
/// Where a head goes to be calibrated: it looks for a landmark, finds how far it can turn with one in sight, and makes
/// stops all over that, to which both axes come from both sides.
///
///     FIND   directions about where it waits, the nearest first, until one shows a landmark
///     REACH  from there to each side, in steps, until none is in sight or the axis's limit is met
///     GRID   rows within these ends, to and fro, upwards, and back again between those
///     HOME   where it is left
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/head_angles.h"

namespace ninedot {

struct HeadTourOptions {
  HeadAngles min, max;         ///< it is never sent beyond [rad]
  HeadAngles start, home;      ///< where it begins to look, and where it is left; within the limits (contract) [rad]
  double half_width_rad = 0;   ///< of what the picture shows beside its middle, > 0 (contract)
  double half_height_rad = 0;  ///< likewise
  int columns = 7, rows = 5;   ///< stops of the grid, two at least (contract)
};

/// Knows no clock and no head: who drives it says when the head has arrived, and what each picture from then on shows.
/// Memory: allocates. Threads: one.
class HeadTour {
 public:
  /// Less of a turn is no use, see head_sufficiency.h: then the tour goes home without a grid.
  explicit HeadTour(const HeadTourOptions& options);

  enum class Part : std::uint8_t { kFind, kReach, kGrid, kHome };
  Part part() const noexcept { return part_; }
  HeadAngles goal() const noexcept { return goal_; }  ///< where the head is to stand now [rad]

  /// A picture that was exposed while the head stood at `goal`. \param direction  in which it shows a landmark, at z =
  /// 1 [1]; none: it shows none \return  whether that was enough, and `goal` is another one now
  bool look(const std::optional<Eigen::Vector2d>& direction);
  /// The head can't go there: on without it.
  void skip() { advance(false); }

  std::size_t stops_made() const noexcept { return made_; }
  /// How many there will be, as far as is known; 0: not yet. [1]
  std::size_t stops_planned() const noexcept { return planned_; }

 private:
  void advance(bool is_seen);
  void go_on_finding(bool is_seen);
  void begin_reach();
  void go_on_reaching(bool is_seen);
  void try_next_side();
  bool step_out();
  void begin_grid();

  const HeadTourOptions options_;
  Part part_ = Part::kFind;
  HeadAngles goal_;
  std::vector<HeadAngles> way_;  // of kFind, and of kGrid
  std::size_t next_ = 0, made_ = 0, planned_ = 0;
  HeadAngles base_, low_, high_;  // of kReach
  std::size_t side_ = 0;

  int looks_ = 0, sights_ = 0, steady_ = 0;  // at this goal
  Eigen::Vector2d before_ = Eigen::Vector2d::Zero();
};

}  // namespace ninedot
