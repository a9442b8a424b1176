#include "drivers/recording/recording_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/startup_error.h"
#include "drivers/posix/whole_file.h"

namespace ninedot {

RecordingReader::RecordingReader(const RecordingIndex& index, PictureSize size)
    : size_(size),
      y4m_size_(index.size),
      y4m_chroma_size_(index.y4m_chroma_size),
      decoder_(index.is_y4m ? PictureSize{} : size),
      file_(index.largest_file_bytes) {
  if (!index.is_y4m) return;
  y4m_ = ::open(index.path.c_str(), O_RDONLY | O_CLOEXEC);
  if (y4m_ < 0) throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", index.path, std::strerror(errno)));
}

RecordingReader::~RecordingReader() {
  if (y4m_ >= 0) ::close(y4m_);
}

Result<ChromaView> RecordingReader::read(const RecordedFrame& frame, std::span<std::uint8_t> luma,
                                         std::span<std::uint8_t> chroma) noexcept {
  return y4m_ >= 0 ? read_y4m(frame, luma, chroma) : read_picture(frame, luma, chroma);
}

Result<ChromaView> RecordingReader::read_picture(const RecordedFrame& frame, std::span<std::uint8_t> luma,
                                                 std::span<std::uint8_t> chroma) noexcept {
  const Result<std::size_t> bytes = read_whole_file(frame.file.c_str(), file_);
  if (!bytes) {
    const int os_errno = bytes.error().os_errno;
    return fail(Errc::kFrameUnreadable,
                os_errno == ENOENT  ? "the picture is missing"
                : os_errno == EFBIG ? "the picture file grew while the recording was open"
                                    : "the picture file can't be read",
                os_errno);
  }
  return decoder_.decode_with_chroma(std::span(file_).first(*bytes), luma, chroma);
}

Result<ChromaView> RecordingReader::read_y4m(const RecordedFrame& frame, std::span<std::uint8_t> luma,
                                             std::span<std::uint8_t> chroma) noexcept {
  if (frame.offset_bytes < 0)
    return fail(Errc::kFrameUnreadable, "a frame does not start with FRAME: the file is damaged");
  if (y4m_size_ != size_) return fail(Errc::kFrameSize, "the picture's size is not the camera's");
  NINEDOT_TRY(const std::size_t luma_bytes, read_y4m_bytes(frame.offset_bytes, luma));
  const std::size_t plane_bytes = y4m_chroma_size_.pixel_count();
  if (plane_bytes == 0) return ChromaView{};
  // A file that was cut off within the colour of its last frame has that frame's luma still.
  if (!read_y4m_bytes(frame.offset_bytes + static_cast<std::int64_t>(luma_bytes), chroma.first(2 * plane_bytes)))
    return ChromaView{};
  const int width = y4m_chroma_size_.width_px;
  return ChromaView{chroma.data(), chroma.data() + plane_bytes, width, y4m_chroma_size_.height_px, 1, width};
}

Result<std::size_t> RecordingReader::read_y4m_bytes(std::int64_t offset_bytes, std::span<std::uint8_t> to) noexcept {
  std::size_t done = 0;
  while (done < to.size()) {
    const ssize_t count =
        ::pread(y4m_, to.data() + done, to.size() - done, offset_bytes + static_cast<std::int64_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail(Errc::kFrameUnreadable, "the file can't be read", errno);
    if (count == 0) return fail(Errc::kFrameUnreadable, "the file is truncated");
    done += static_cast<std::size_t>(count);
  }
  return done;
}

}  // namespace ninedot
