#pragma once
/// The service's end of the tap (docs/tap.md): the newest frame and what came of it, in shared memory that others may
/// read. Whatever they do, nothing here waits for them or believes them: they can write nothing.
#include <atomic>
#include <cstdint>
#include <string>

#include "drivers/tap/tap_demand.h"
#include "drivers/tap/tap_file.h"
#include "image/chroma_view.h"
#include "image/image_view.h"
#include "proto/tap_layout.h"

namespace ninedot {

/// Memory: one file in memory of three slots, each with room for luma and chroma at every pixel; made, touched and
/// locked by the constructor. Threads: see each method.
class TapWriter {
 public:
  /// Makes the file under a temporary name and then gives it its own, so that who opens it finds it complete: mode
  /// 0640, with the group that its folder gives (setgid). What a crashed service left is replaced, and nothing else.
  /// \param header  what is known of software, camera and landmark; places, sizes and counts are filled in here
  /// Throws StartupError(kWorkFailed), one line: the folder or the memory can't be had, another service serves there,
  /// something else stands there.
  TapWriter(const std::string& path, TapHeader header);
  /// Takes the name away.
  ~TapWriter();
  TapWriter(const TapWriter&) = delete;
  TapWriter& operator=(const TapWriter&) = delete;

  /// Asks the kernel whether anybody reads: two system calls, for every few milliseconds. Threads: one ordinary one.
  void look_for_readers() noexcept;
  /// What was asked for then. Threads: any.
  TapDemand demand() const noexcept { return demand_.load(std::memory_order_relaxed); }

  /// The next frame, into the slot that was newest longest ago. Allocates nothing, waits for nobody, one copy.
  /// \param frame  all but its `picture`, which is filled in here
  /// \param luma  of the frame; empty, or more than fits: none is published
  /// \param chroma  of the same; empty: the picture is grey
  /// Threads: the frame loop's alone.
  void publish(TapFrame& frame, const ImageView& luma, const ChromaView& chroma) noexcept;

  /// Threads: one ordinary one.
  void publish(const TapService& service) noexcept;

 private:
  std::string path_;
  FileDescriptor file_;
  SharedBytes bytes_;
  TapHeader places_;  // as written; what is in the memory is never read back
  std::uint64_t frames_ = 0, services_ = 0;
  std::atomic<TapDemand> demand_{TapDemand::kNothing};
};

}  // namespace ninedot
