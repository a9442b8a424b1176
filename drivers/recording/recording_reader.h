#pragma once
/// Decodes the pictures of a recording, in any order.
#include <memory>
#include <vector>

#include "drivers/picture/picture_file.h"
#include "drivers/recording/recording_index.h"

namespace ninedot {

/// Memory: the constructor allocates for the largest picture file; beyond that the picture libraries allocate inside
/// `read`. Threads: one caller.
class RecordingReader {
 public:
  /// \param size  that all pictures must have. Throws StartupError(kWorkFailed) when a .y4m file can't be opened.
  RecordingReader(const RecordingIndex& index, PictureSize size);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  /// \param luma  size.pixel_count() bytes (contract); undefined after a failure
  /// \error kFrameUnreadable: missing, truncated or damaged. kFrameSize: of another size.
  Result<PictureSize> read(const RecordedFrame& frame, std::span<std::uint8_t> luma) noexcept;

 private:
  Result<PictureSize> read_picture(const RecordedFrame& frame, std::span<std::uint8_t> luma) noexcept;
  Result<PictureSize> read_y4m(const RecordedFrame& frame, std::span<std::uint8_t> luma) noexcept;

  PictureSize size_;
  PictureSize y4m_size_;
  PictureDecoder decoder_;
  std::vector<std::uint8_t> file_;
  int y4m_ = -1;  ///< descriptor of the .y4m file
};

}  // namespace ninedot
