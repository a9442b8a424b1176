#pragma once
/// Frames of the tap for what records frames of cameras.
#include <cstdint>

#include "drivers/tap/tap_reader.h"
#include "ports/frame_source.h"

namespace ninedot {

/// \param copy  must outlive the lease: the pixels are its own
/// \param publication_before  of the frame that was taken last, so that what lies between is counted; 0: none
/// Memory: none. Threads: pure.
FrameLease lease_of(const TapCopy& copy, std::uint64_t publication_before) noexcept;

}  // namespace ninedot
