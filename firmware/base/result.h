#pragma once
/// Failures that a caller can expect: `Result<T>` carries either the value or an `Error`. Bugs go to contract.h.
#include <cstdint>
#include <tl/expected.hpp>
#include <type_traits>

namespace ninedot {

/// What went wrong, for the program. A test reaches every one of them.
enum class Errc : std::uint16_t {
  kNoFrame = 1,      ///< the source has no frame (yet)
  kEndOfStream,      ///< a recording that does not loop is over
  kCameraLost,       ///< the device vanished or stalled
  kFrameSize,        ///< a frame's size is not the calibration's
  kFrameUnreadable,  ///< a picture is missing, truncated or of an unknown kind
  kNoLandmark,       ///< nothing in the picture is a landmark
  kPoseDegenerate,   ///< the visible part does not determine a pose
  kIo,               ///< the operating system refused; see os_errno
};

/// Trivially copyable, so that it can cross the frame path without a heap.
struct Error {
  Errc code;
  int os_errno = 0;       ///< errno where the operating system spoke, else 0
  const char* text = "";  ///< a literal: what happened, one line, no newline
};
static_assert(std::is_trivially_copyable_v<Error>);

template <typename T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(Errc code, const char* text, int os_errno = 0) noexcept {
  return tl::unexpected<Error>(Error{code, os_errno, text});
}

}  // namespace ninedot

/// `NINEDOT_TRY(const Dots dots, find_dots(image));` declares `dots`, or returns the error from the enclosing function.
#define NINEDOT_TRY(declaration, expression) NINEDOT_TRY_(declaration, expression, NINEDOT_CONCAT(result_, __LINE__))
#define NINEDOT_TRY_(declaration, expression, result)                   \
  auto result = (expression);                                           \
  if (!result) return tl::unexpected<::ninedot::Error>(result.error()); \
  declaration = *std::move(result)
#define NINEDOT_CONCAT(a, b) NINEDOT_CONCAT_(a, b)
#define NINEDOT_CONCAT_(a, b) a##b
