#pragma once
/// What the benchmark of aiming drives through: robots before one landmark, and the servos of two kinds of head.
#include <cstdint>
#include <optional>
#include <vector>

#include "config/config.h"
#include "programs/simulation/virtual_run.h"

namespace ninedot::bench {

/// The servos that figures are for.
enum class ServoKind : std::uint8_t {
  kHobby,  ///< 0.17 s for 60 deg, dead band of 1 deg, steps of 0.1 deg (1 us of its pulses)
  kSmart,  ///< as fast, steps of 0.1 deg, no dead band
};

/// \param camera_delay_ms  mid-exposure to arrival \param servo_delay_ms  command to servo
Config base_scenario(ServoKind servo, double camera_delay_ms, double servo_delay_ms);

/// Stands 1.5 m before the landmark, the head `off_deg` to the left of it.
Config standing(Config base, double off_deg, double duration_s);

/// Begins at rest with the head on the landmark; from 1 s on it drives past, 1.5 m before it, from 2 m at its left to
/// 2 m at its right. \param speed_m_s  0: it stays where it begins, for 4 s
Config passing(Config base, double speed_m_s);

/// Where passing() has the robot in the middle.
double passing_middle_s(double speed_m_s);

/// Covers everything. \param length_s  of it
Config hidden(Config scenario, double from_s, double length_s);

/// Drives 3.4 m while everything is covered for 5 s, so that the landmark is far out of the picture then, and stands
/// there covered for `longer_s` more: where the search is when it could be seen again differs.
Config lost(Config base, double longer_s);
inline constexpr double kLostFrom_s = 1, kLostTo_s = 6;

/// The longest that the head's search takes to show everything within its reach once, wherever it begins [s].
double sweep_s(const Config& scenario);

/// What nobody can prevent: how far off a landmark is, passing() having set off at once, before the first frame that
/// shows its motion can have moved the servo [deg]. Frames come when they come: the worst of all phases.
double unforeseeable_deg(const Config& scenario, double speed_m_s);

/// All its rows. \param gains  PID's, none: of the project's controller
std::vector<SimulationRow> drive(const Config& scenario, const std::optional<PidGains>& gains);

}  // namespace ninedot::bench
