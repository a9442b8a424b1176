#pragma once
/// Drives a head along its tour: orders out, pictures in.
#include <cstdint>
#include <optional>
#include <vector>

#include "calibrate_head/head_stops.h"
#include "calibrate_head/head_tour.h"
#include "config/config.h"
#include "outputs/head_output.h"
#include "pipeline/frame_processor.h"
#include "programs/commands/toured_head.h"

namespace ninedot {

/// Within the axes' limits, from where the head waits (neutral_deg); left there, or parked where park_at_shutdown says.
HeadTourOptions tour_options(const Config& config, const CameraModel& camera, int columns, int rows);

/// Servos of this process. The head's own thread, or whoever takes its place, moves them: HeadOutput::take.
/// Threads: the one that takes the snapshots of `head`.
class OutputHead final : public TouredHead {
 public:
  /// \param head  follows no landmark; must outlive this
  explicit OutputHead(HeadOutput& head) noexcept : head_(head) {}

  void go(const HeadAngles& goal) override;
  State state(const Frame& frame) override;

 private:
  HeadOutput& head_;
  std::uint32_t number_ = 0;
};

/// Memory: allocates. Threads: one.
class HeadTourDrive {
 public:
  /// \param head  must outlive this
  HeadTourDrive(const HeadTourOptions& options, TouredHead& head);

  /// After each picture.
  void take(const Frame& frame, const Fix& fix);

  bool is_over() const noexcept { return is_over_; }
  /// The inhibit input keeps the head where it is: the tour waits.
  bool is_inhibited() const noexcept { return head_now_.is_inhibited; }
  /// The head could not be moved, or does not answer.
  bool is_failing() const noexcept { return head_now_.is_failed; }
  const HeadTour& tour() const noexcept { return tour_; }
  const HeadAngles& told() const noexcept { return head_now_.told; }  ///< of the last picture
  const std::vector<HeadFrame>& frames() const noexcept { return frames_; }

 private:
  std::optional<Eigen::Vector2d> direction_in(const HeadFrame& frame);

  HeadTour tour_;
  TouredHead& head_;
  TouredHead::State head_now_;
  std::vector<HeadFrame> frames_;
  std::uint16_t looked_at_ = 0;
  bool is_over_ = false, is_held_ = false;
};

}  // namespace ninedot
