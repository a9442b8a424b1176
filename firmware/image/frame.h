#pragma once
/// One picture of a camera, with what is known of its making.
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>

#include "base/head_angles.h"
#include "base/mono_time.h"
#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot {

/// Goes by const reference from the lease through the whole pipeline. The pixels belong to whoever lent the frame.
/// Threads: one at a time.
struct Frame {
  std::uint64_t number = 0;  ///< the source's own count (a recording's frame number; a camera's sequence)
  ImageView luma;
  ChromaView chroma;  ///< empty where the source gives no colour

  /// Exposure of the picture's middle row. Equal where its length is unknown.
  MonoTime exposure_begin{}, exposure_end{};
  /// From the exposure of one row to that of the next one below it: 0 = global shutter, or unknown.
  std::chrono::nanoseconds row_time{};

  double gain = std::numeric_limits<double>::quiet_NaN();           ///< as a factor; NaN: unknown
  double focus_dioptre = std::numeric_limits<double>::quiet_NaN();  ///< 1 / distance [1/m]; NaN: unknown or fixed
  double zoom = std::numeric_limits<double>::quiet_NaN();  ///< the lens's own position [steps]; NaN: unknown or fixed

  /// Where the head stood, if the source knows (recordings do), and when that was true.
  std::optional<HeadAngles> head;
  MonoTime head_at{};

  /// Middle of the exposure: the instant that a pose is of.
  MonoTime exposed_at() const noexcept { return exposure_begin + (exposure_end - exposure_begin) / 2; }
  /// \param duration  0: unknown
  void set_exposure(MonoTime middle, std::chrono::nanoseconds duration = {}) noexcept {
    exposure_begin = middle - duration / 2;
    exposure_end = exposure_begin + duration;
  }
};

}  // namespace ninedot
