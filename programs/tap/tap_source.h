#pragma once
/// A running service's frames as a source like any camera: for commands that look at what the service sees.
#include <cstdint>
#include <string>

#include "drivers/tap/tap_reader.h"
#include "ports/frame_source.h"

namespace ninedot {

/// The newest frame each time, at the rate for eyes (kTapSomePeriod_ns); what comes between is left out and counted.
/// One lease at a time: its pixels are this object's copy. Memory: the tap's mapping and one frame.
class TapSource final : public FrameSource {
 public:
  /// Throws StartupError(kWorkFailed) as TapReader does.
  explicit TapSource(const std::string& path);

  /// \error kNoFrame: none came in time. kCameraLost: the service has ended. kFrameSize: this frame came without a
  /// picture.
  Result<FrameLease> next(MonoTime deadline) noexcept override;
  const TapHeader& header() const noexcept { return reader_.header(); }
  /// Why there will be no more, one line; empty: not known, ask again.
  std::string last_failure() const;

 private:
  TapReader reader_;
  TapCopy copy_;
  std::uint64_t publication_before_ = 0;
  Errc failure_ = Errc::kNoFrame;
};

}  // namespace ninedot
