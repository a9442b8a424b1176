#include "programs/tap/tap_source.h"

#include <chrono>
#include <thread>

#include "programs/tap/tap_lease.h"

namespace ninedot {
namespace {

/// Between two looks: a small part of the time between two frames for eyes.
constexpr std::chrono::milliseconds kPause{5};

}  // namespace

TapSource::TapSource(const std::string& path) : reader_(path) { reader_.announce(TapDemand::kSome); }

Result<FrameLease> TapSource::next(MonoTime deadline) noexcept {
  const auto failed = [this](Errc code, const char* text) {
    failure_ = code;
    return tl::unexpected(Error{code, 0, text});
  };
  while (!reader_.copy_newest(copy_)) {
    if (!reader_.is_alive()) return failed(Errc::kCameraLost, "the service has ended");
    if (mono_now() >= deadline) return failed(Errc::kNoFrame, "the service gives no frame");
    std::this_thread::sleep_for(kPause);
  }
  FrameLease lease = lease_of(copy_, publication_before_);
  publication_before_ = copy_.publication;
  if (lease.frame.luma.empty()) return failed(Errc::kFrameSize, "the service's frames come without a picture");
  return lease;
}

std::string TapSource::last_failure() const {
  if (failure_ == Errc::kCameraLost) return "the service has ended: start it, and calibrate again";
  if (failure_ == Errc::kFrameSize)
    return "the service's pictures are larger than its calibration: set camera.width_px and height_px, and start it "
           "with a calibration of that size";
  return {};
}

}  // namespace ninedot
