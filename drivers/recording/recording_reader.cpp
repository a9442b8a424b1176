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
      decoder_(index.is_y4m ? PictureSize{} : size),
      file_(index.largest_file_bytes) {
  if (!index.is_y4m) return;
  y4m_ = ::open(index.path.c_str(), O_RDONLY | O_CLOEXEC);
  if (y4m_ < 0) throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: {}", index.path, std::strerror(errno)));
}

RecordingReader::~RecordingReader() {
  if (y4m_ >= 0) ::close(y4m_);
}

Result<PictureSize> RecordingReader::read(const RecordedFrame& frame, std::span<std::uint8_t> luma) noexcept {
  return y4m_ >= 0 ? read_y4m(frame, luma) : read_picture(frame, luma);
}

Result<PictureSize> RecordingReader::read_picture(const RecordedFrame& frame, std::span<std::uint8_t> luma) noexcept {
  const Result<std::size_t> bytes = read_whole_file(frame.file.c_str(), file_);
  if (!bytes) {
    const int os_errno = bytes.error().os_errno;
    return fail(Errc::kFrameUnreadable,
                os_errno == ENOENT  ? "the picture is missing"
                : os_errno == EFBIG ? "the picture file grew while the recording was open"
                                    : "the picture file can't be read",
                os_errno);
  }
  return decoder_.decode(std::span(file_).first(*bytes), luma);
}

Result<PictureSize> RecordingReader::read_y4m(const RecordedFrame& frame, std::span<std::uint8_t> luma) noexcept {
  if (frame.offset_bytes < 0)
    return fail(Errc::kFrameUnreadable, "a frame does not start with FRAME: the file is damaged");
  if (y4m_size_ != size_) return fail(Errc::kFrameSize, "the picture's size is not the camera's");
  std::size_t done = 0;
  while (done < luma.size()) {
    const ssize_t count =
        ::pread(y4m_, luma.data() + done, luma.size() - done, frame.offset_bytes + static_cast<std::int64_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail(Errc::kFrameUnreadable, "the file can't be read", errno);
    if (count == 0) return fail(Errc::kFrameUnreadable, "the file is truncated");
    done += static_cast<std::size_t>(count);
  }
  return size_;
}

}  // namespace ninedot
