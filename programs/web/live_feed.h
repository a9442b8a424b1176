#pragma once
/// The tap as the page sees it: one message at a time, made once for all who look, while somebody looks.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/mono_time.h"
#include "drivers/picture/jpeg_encoder.h"
#include "drivers/tap/tap_demand.h"
#include "drivers/tap/tap_reader.h"

namespace ninedot {

/// What pages are given: JSON, and where there is one the picture that it is about.
struct LiveMessage {
  std::uint64_t number = 0;  ///< the feed's own count, from 1
  std::string json;
  std::string jpeg;  ///< the file's bytes; empty: no picture
};

/// Memory: allocates for each message. Threads: one.
class LiveFeed {
 public:
  /// \param quality  1..100, of JPEG
  LiveFeed(std::string tap_path, int quality) : path_(std::move(tap_path)), quality_(quality) {}

  /// The newest state, whatever it is: a service that has gone is a message as well. Opens the tap where that is due.
  /// \param demand  which frames are wanted from now on: kSome or kEvery
  std::shared_ptr<const LiveMessage> next(MonoTime now, TapDemand demand);
  /// Whether there is a frame that no message was about yet. No system call.
  bool has_newer() const noexcept;
  /// Nobody looks: the service is to fill the tap no longer.
  void rest() noexcept;

 private:
  void look_for_service(MonoTime now);
  void encode_picture();

  const std::string path_;
  const int quality_;
  std::optional<TapReader> tap_;
  std::string problem_;  // why there is no tap_
  MonoTime looked_at_{};
  TapDemand demand_ = TapDemand::kNothing;  // as tap_ was told
  TapCopy copy_;
  std::uint64_t service_seen_ = 0;
  TapService service_;
  JpegEncoder encoder_;
  std::string jpeg_;
  std::uint64_t number_ = 0;
};

}  // namespace ninedot
