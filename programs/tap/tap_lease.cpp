#include "programs/tap/tap_lease.h"

#include "base/units.h"

namespace ninedot {

FrameLease lease_of(const TapCopy& copy, std::uint64_t publication_before) noexcept {
  FrameLease lease;
  lease.frame.luma = copy.luma();
  lease.frame.chroma = copy.chroma();
  lease.frame.set_exposure(mono_from_ns(copy.frame.exposed_at_ns));
  if ((copy.frame.flags & tap_flag::kHasHead) != 0)
    lease.frame.head = HeadAngles{copy.frame.head_pan_deg * kRadPerDeg, copy.frame.head_tilt_deg * kRadPerDeg};
  if (publication_before != 0)
    lease.dropped_before = static_cast<std::uint32_t>(copy.publication - publication_before - 1);
  return lease;
}

}  // namespace ninedot
