#include "drivers/recording/recording_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <span>

#include "base/startup_error.h"
#include "base/units.h"
#include "drivers/picture/picture_file.h"
#include "proto/frames_csv.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

std::span<const std::uint8_t> bytes_of(std::string_view text) noexcept {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

RecordingWriter::RecordingWriter(const std::string& folder, std::string_view camera_yaml, WriteFunction write_bytes,
                                 bool with_zoom)
    : folder_(folder), write_bytes_(write_bytes), with_zoom_(with_zoom) {
  make_folder();
  const auto refuse = [&](const std::string& file, int os_errno) {
    remove_folder();
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", file, std::strerror(os_errno)));
  };
  if (!camera_yaml.empty()) {
    const std::string file = folder_ + "/camera.yaml";
    const Result<std::size_t> written =
        write_whole_file(file, bytes_of(camera_yaml), Durability::kPowerCut, write_bytes_);
    if (!written) refuse(file, written.error().os_errno);
  }
  const std::string file = folder_ + "/frames.csv";
  csv_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (csv_ < 0) refuse(file, errno);
  const Result<std::size_t> written = append_row(with_zoom ? kFramesCsvHeaderWithZoom : kFramesCsvHeader);
  if (!written) refuse(file, written.error().os_errno);
}

RecordingWriter::~RecordingWriter() {
  if (frame_count_ == 0)
    remove_folder();
  else
    ::close(csv_);
}

void RecordingWriter::make_folder() {
  std::error_code error;
  if (fs::exists(folder_) && !(fs::is_directory(folder_) && fs::is_empty(folder_, error)))
    throw StartupError(
        ExitStatus::kWrongUsage,
        fmt::format("{}: is there already and not empty; give a new folder, or empty this one", folder_));
  for (fs::path place = fs::absolute(folder_).lexically_normal(); !place.empty() && !fs::exists(place);
       place = place.parent_path())
    first_made_ = place.string();
  fs::create_directories(fs::path(folder_) / "frames", error);
  if (!error) return;
  remove_folder();
  throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: can't be made: {}", folder_, error.message()));
}

/// Only what this object made, and only while nothing is recorded in it.
void RecordingWriter::remove_folder() noexcept {
  if (csv_ >= 0) ::close(csv_);
  csv_ = -1;
  std::error_code ignored;
  for (const char* const name : {"/frames.csv", "/camera.yaml", "/frames"}) fs::remove(folder_ + name, ignored);
  if (!first_made_.empty()) {
    for (fs::path place = fs::absolute(folder_, ignored).lexically_normal();; place = place.parent_path()) {
      if (!fs::remove(place, ignored) || place == fs::path(first_made_)) break;
    }
  }
}

/// A row is there whole or not at all.
Result<std::size_t> RecordingWriter::append_row(std::string_view row) noexcept {
  const Result<std::size_t> written = write_all(csv_, bytes_of(row), write_bytes_);
  if (written) {
    csv_bytes_ += static_cast<std::int64_t>(row.size());
  } else if (::ftruncate(csv_, csv_bytes_) != 0 || ::lseek(csv_, csv_bytes_, SEEK_SET) < 0) {
    return fail(Errc::kIo, "frames.csv can't be repaired", errno);
  }
  return written;
}

Result<std::size_t> RecordingWriter::encode(const Frame& frame) {
  if (frame.chroma.empty()) return encode_png_grey(frame.luma, png_);
  const PictureSize size{frame.luma.width_px, frame.luma.height_px};
  rgb_.resize(3 * size.pixel_count());
  rgb_from_ycbcr(frame.luma, frame.chroma, rgb_);
  return encode_png_rgb(rgb_, size, png_);
}

Result<std::uint64_t> RecordingWriter::add(const FrameLease& lease) {
  const Frame& frame = lease.frame;
  const HeadAngles head = frame.head.value_or(HeadAngles{});
  const std::uint64_t number = next_number_ + (frame_count_ > 0 ? lease.dropped_before : 0);
  const std::string picture = fmt::format("{}/frames/{:06}.png", folder_, number);
  NINEDOT_TRY(const std::size_t encoded_bytes, encode(frame));
  const Result<std::size_t> written =
      write_whole_file(picture, std::span(png_).first(encoded_bytes), Durability::kWhenConvenient, write_bytes_);
  if (!written) return tl::unexpected<Error>(written.error());
  FramesCsvRow csv_row{number, to_ns(frame.exposed_at()), head.pan_rad * kDegPerRad, head.tilt_rad * kDegPerRad, {}};
  if (!std::isnan(frame.zoom)) csv_row.zoom = static_cast<int>(std::lround(frame.zoom));
  const Result<std::size_t> row = append_row(format_frames_csv_row(csv_row, with_zoom_));
  if (!row) {
    ::unlink(picture.c_str());
    return tl::unexpected<Error>(row.error());
  }
  next_number_ = number + 1;
  ++frame_count_;
  return number;
}

}  // namespace ninedot
