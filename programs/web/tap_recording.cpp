#include "programs/web/tap_recording.h"

#include <fmt/format.h>

#include <cerrno>
#include <filesystem>

#include "base/contract.h"
#include "calibrate/camera_file.h"
#include "programs/tap/tap_frame.h"
#include "programs/tap/tap_lease.h"
#include "programs/web/live_json.h"

namespace ninedot {

TapRecording::TapRecording(const std::string& folder, const TapHeader& header, WriteFunction write_bytes)
    : folder_(folder), camera_json_(camera_json(header)), write_bytes_(write_bytes) {
  writer_.emplace(folder, format_camera(camera_of(header), "recorded"), write_bytes);
  entry_.name = std::filesystem::path(folder).filename().string();
}

Result<std::uint64_t> TapRecording::write(const std::string& name, std::string_view text) {
  NINEDOT_TRY(const std::size_t bytes,
              write_whole_file(folder_ + "/" + name, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()},
                               Durability::kWhenConvenient, write_bytes_));
  return std::uint64_t{bytes};
}

Result<std::uint64_t> TapRecording::add(const TapCopy& copy) {
  EXPECTS(writer_ && !copy.luma().empty());
  const FrameLease lease = lease_of(copy, publication_);
  NINEDOT_TRY(const std::uint64_t number, writer_->add(lease));
  publication_ = copy.publication;
  if (entry_.frames == 0) first_ns_ = copy.frame.exposed_at_ns;
  entry_.frames = writer_->frame_count();
  entry_.missed = number + 1 - entry_.frames;
  entry_.duration = std::chrono::nanoseconds(copy.frame.exposed_at_ns - first_ns_);
  std::error_code error;
  std::uint64_t bytes = std::filesystem::file_size(fmt::format("{}/frames/{:06}.png", folder_, number), error);
  if (entry_.frames == 1) {
    std::filesystem::create_directory(folder_ + "/reports", error);
    NINEDOT_TRY(const std::uint64_t camera_bytes, write("camera.json", camera_json_));
    bytes += camera_bytes;
  }
  // The pose's age as it was when the report came out, not as it is while this is written.
  const std::string report = frame_json(copy.frame, mono_from_ns(copy.frame.published_at_ns));
  NINEDOT_TRY(const std::uint64_t report_bytes, write(fmt::format("reports/{:06}.json", number), report));
  bytes += report_bytes;
  entry_.bytes += bytes;
  return bytes;
}

std::optional<ShelfEntry> TapRecording::end(std::string_view why) {
  writer_.reset();
  if (entry_.frames == 0) return std::nullopt;
  entry_.ended = why;
  // On a full disk it stays without, and is called cut off when the program starts again.
  static_cast<void>(write("ended.txt", why));
  return entry_;
}

}  // namespace ninedot
