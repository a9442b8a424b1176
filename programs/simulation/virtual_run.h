#pragma once
/// A scenario in virtual time: the simulated camera, the service's own frame path and aiming, and the simulated head,
/// in a closed loop that waits for nothing. The same configuration and seed give the same rows.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "config/config.h"
#include "drivers/simulation/simulated_camera.h"
#include "geometry/body.h"
#include "outputs/head_output.h"
#include "pipeline/frame_processor.h"
#include "programs/simulation/pixel_pid.h"

namespace ninedot {

enum class SimulatedController : std::uint8_t { kServoing, kPid };

struct VirtualRunOptions {
  std::uint64_t seed = 1;  ///< of the camera's noise
  SimulatedController controller = SimulatedController::kServoing;
  PidGains pid{};
};

/// One frame: what was true in the middle of its exposure, and what came of it.
struct SimulationRow {
  SimulationTruth truth;
  HeadAngles command;       ///< as the head was told last, after the frame
  std::string_view state;   ///< of the controller
  bool valid = false;       ///< the frame's pose may be acted on
  bool found = false;       ///< the frame shows a landmark
  double pose_error_m = 0;  ///< of a valid one: between the camera and where the pose in the world has it
};

/// Memory: allocates by the constructor. Threads: one.
class VirtualRun {
 public:
  /// The head is the simulated one, whatever `pan_tilt.driver` says.
  /// Throws StartupError(kWrongUsage), as simulation_options.
  VirtualRun(const Config& config, const CameraModel& camera, const VirtualRunOptions& options);

  /// Simulates up to the next frame's arrival, and what follows from it. \return  nothing: the scenario is over
  std::optional<SimulationRow> next() noexcept;

 private:
  const HeadSnapshot& snapshot() noexcept;

  VirtualClock clock_;
  std::shared_ptr<HeadLine> line_ = std::make_shared<HeadLine>();
  SimulatedCamera camera_;
  SimulatedHead head_;
  std::unique_ptr<FrameProcessor> localiser_;
  std::optional<HeadOutput> servoing_;
  std::optional<PixelPid> pid_;
  Output* controller_ = nullptr;  // one of the two
  const BodyGeometry body_;
  Report report_;
  MonoTime taken_at_;
};

/// The header and the rows of `ninedot simulate`: docs/simulation.md says what the columns are.
std::string simulation_csv_header();
std::string simulation_csv_row(const SimulationRow& row);

}  // namespace ninedot
