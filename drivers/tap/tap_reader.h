#pragma once
/// A reader's end of the tap: opens it, says that it reads, copies the newest frame whole.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "drivers/tap/tap_demand.h"
#include "drivers/tap/tap_file.h"
#include "image/chroma_view.h"
#include "image/image_view.h"
#include "proto/tap_layout.h"

namespace ninedot {

/// One publication, copied.
struct TapCopy {
  std::uint64_t publication = 0;  ///< how many there had been with it; 0: none
  TapFrame frame;
  std::vector<std::uint8_t> pixels;
  ImageView luma() const noexcept;
  ChromaView chroma() const noexcept;
};

/// Memory: the mapping; copies are the caller's. Threads: one at a time.
class TapReader {
 public:
  /// Throws StartupError(kWorkFailed), one line that says what to do: no tap, no right to read it, no service behind
  /// it, another version.
  explicit TapReader(const std::string& path);

  /// The service that made this tap still runs. One system call.
  bool is_alive() const noexcept;
  /// From now on the service is to fill the tap: with some frames for eyes, with every one for a recording, or no
  /// longer. It looks every 20 ms. Ends with this object, or with
  /// this process. What the tap holds already is of whenever somebody read last, and is not given any more.
  void announce(TapDemand demand) noexcept;

  /// As of its making: software, camera, landmark.
  const TapHeader& header() const noexcept { return header_; }

  /// \param copy  filled with the newest frame, where it is newer than copy.publication; its memory is used again
  /// \return  whether it was; false also where the writer was too quick three times over
  bool copy_newest(TapCopy& copy) const;
  /// Whether copy_newest would find one: a look at one word.
  bool has_newer(const TapCopy& copy) const noexcept;
  /// \param seen  how many publications the caller has seen; updated
  /// \param service  filled likewise
  bool copy_newest(std::uint64_t& seen, TapService& service) const noexcept;

 private:
  FileDescriptor file_;
  SharedBytes bytes_;
  TapHeader header_;
  std::uint64_t frames_before_ = 0, services_before_ = 0;  // publications when reading began
};

}  // namespace ninedot
