#pragma once
/// All that a localiser has made for one lens. A camera whose zoom moves gets another one: it is made on another
/// thread, and takes the place of the one before between two frames.
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "base/object_handoff.h"
#include "colour/dot_colours.h"
#include "image/frame.h"
#include "pipeline/calibration_error.h"
#include "pipeline/landmark_seeker.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one at a time.
struct Lens {
  /// \param intrinsics  of the calibration [px^2, px, 1]; none: it does not say how good it is
  /// \param at_zoom  [steps]: for frames at this position alone; none: for all frames
  Lens(const CameraModel& camera, const SeekerOptions& options, const std::optional<IntrinsicCovariance>& intrinsics,
       std::optional<int> at_zoom = {})
      : zoom(at_zoom),
        seeker(camera, options),
        colours(camera, options.landmark),
        calibration_error(camera, options.landmark, intrinsics) {}

  std::optional<int> zoom;  ///< [steps] as the constructor's
  LandmarkSeeker seeker;
  ColourReader colours;
  CalibrationError calibration_error;
};

/// Between a localiser, which tells at which zoom its frames are, and a thread that makes lenses.
/// Memory: two pointers and a word. Threads: see each method.
class LensExchange {
 public:
  /// Wait-free; wakes who waits for a wish when it is another one than before. \param zoom  [steps] >= 0
  /// Threads: one, the localiser's.
  void ask(int zoom) noexcept;
  /// The newest lens; null: there is none. Wait-free. Threads: the localiser's.
  std::unique_ptr<Lens> take() noexcept { return lenses_.take(); }
  /// One for each that was taken (contract). Wait-free. Threads: the localiser's.
  void give_back(std::unique_ptr<Lens> lens) noexcept { lenses_.give_back(std::move(lens)); }

  /// Frees what was given back. Threads: any ordinary one.
  void put(std::unique_ptr<Lens> lens) noexcept { lenses_.put(std::move(lens)); }
  /// Sleeps until a position other than `than` is asked for, at most until `deadline`. \param than  [steps]
  /// \return  what is asked for [steps]; nothing: nothing yet. Threads: any ordinary one.
  std::optional<int> wait_for_wish(std::optional<int> than, MonoTime deadline) const noexcept;

 private:
  ObjectHandoff<Lens> lenses_;
  std::atomic<std::uint32_t> wish_{0};  // 0: none; else the position and one
};

/// The lens that a localiser looks through. Memory: none after construction. Threads: one, the localiser's.
class LensInUse {
 public:
  enum class Fit : std::uint8_t {
    kSame,     ///< the frame was taken through the lens of the frame before
    kAnother,  ///< it was taken through one that has come meanwhile, and is in use from now on
    kNone,     ///< its zoom is not known, or the lens for it is not there yet
  };

  /// \param others  where lenses for other positions come from; null: there is one lens, for all frames
  LensInUse(std::unique_ptr<Lens> first, LensExchange* others) noexcept : lens_(std::move(first)), others_(others) {}

  /// Before anything is done with a frame.
  Fit fit_to(const Frame& frame) noexcept;

  /// What searches had to leave out, through this lens and all before it.
  WorkCounts counts() const noexcept;

  Lens* operator->() noexcept { return lens_.get(); }
  const Lens* operator->() const noexcept { return lens_.get(); }

 private:
  std::unique_ptr<Lens> lens_;
  LensExchange* others_;
  WorkCounts before_;  // of lenses that were given back
};

}  // namespace ninedot
