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
  /// \param chroma  twice that (contract): where the colour goes
  /// \return  the colour; empty: the picture has none
  /// \error kFrameUnreadable: missing, truncated or damaged. kFrameSize: of another size.
  Result<ChromaView> read(const RecordedFrame& frame, std::span<std::uint8_t> luma,
                          std::span<std::uint8_t> chroma) noexcept;

 private:
  Result<ChromaView> read_picture(const RecordedFrame& frame, std::span<std::uint8_t> luma,
                                  std::span<std::uint8_t> chroma) noexcept;
  Result<ChromaView> read_y4m(const RecordedFrame& frame, std::span<std::uint8_t> luma,
                              std::span<std::uint8_t> chroma) noexcept;
  Result<std::size_t> read_y4m_bytes(std::int64_t offset_bytes, std::span<std::uint8_t> to) noexcept;

  PictureSize size_;
  PictureSize y4m_size_, y4m_chroma_size_;
  PictureDecoder decoder_;
  std::vector<std::uint8_t> file_;
  int y4m_ = -1;  ///< descriptor of the .y4m file
};

}  // namespace ninedot
