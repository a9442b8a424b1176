#pragma once
/// Why there is no valid pose: the codes, and the one place where they are put in words.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace ninedot {

/// The numbers are register values: never renumber, only append.
enum class Reason : std::uint16_t {
  kNone = 0,
  kStarting = 1,
  kNoLandmark = 2,
  kPoseDegenerate = 3,
  kCameraLost = 4,
  kFrameSize = 5,
  kFrameUnreadable = 6,
  kStopped = 7,
  kStale = 8,  ///< set where a report is read, never by the frame loop
  kHeld = 9,   ///< set where a report is read
  kAmbiguous = 10,
  kUncertain = 11,
  kPoorFit = 12,
  kCrowded = 13,
  kNotIdentified = 14,
  kMoved = 15,
  kZoom = 16,
};

struct ReasonWords {
  Reason reason;
  std::string_view sentence;  ///< for logs, tables and documents
  std::string_view label;     ///< at most 41 characters, for a picture
};

/// In the order of their numbers.
inline constexpr auto kReasons = std::to_array<ReasonWords>({
    {Reason::kNone, "the pose is valid", "the pose is valid"},
    {Reason::kStarting, "no frame has been processed yet", "no frame has been processed yet"},
    {Reason::kNoLandmark, "the frame shows no landmark", "the frame shows no landmark"},
    {Reason::kPoseDegenerate, "a landmark was seen, but what is visible does not determine a pose",
     "what is visible determines no pose"},
    {Reason::kCameraLost, "the camera vanished or stalled", "the camera vanished or stalled"},
    {Reason::kFrameSize, "the frame's size is not the calibration's", "the frame's size is not the calibration's"},
    {Reason::kFrameUnreadable, "the picture could not be read", "the picture could not be read"},
    {Reason::kStopped, "the source is over", "the source is over"},
    {Reason::kStale, "the newest pose is too old: no frame has been processed since", "the pose is too old"},
    {Reason::kHeld, "this client holds a pose (register 104) that has become too old", "a held pose is too old"},
    {Reason::kAmbiguous, "a landmark was seen, but two readings of it are too likely: mirror image or numbering",
     "two readings of it are too likely"},
    {Reason::kUncertain, "a landmark was seen, but its pose is too uncertain, or nobody knows where it hangs",
     "its pose is too uncertain"},
    {Reason::kPoorFit, "something like a landmark was seen, but the picture does not fit one",
     "the picture does not fit a landmark"},
    {Reason::kCrowded,
     "no landmark yet: the picture holds more than is searched in one frame, the next goes on with it",
     "too much to search in one frame"},
    {Reason::kNotIdentified, "a landmark was seen, but nothing tells which one of the map it is",
     "which landmark it is isn't known"},
    {Reason::kMoved, "the landmark in view does not hang where the map says", "it hangs elsewhere than the map says"},
    {Reason::kZoom, "the zoom is on its way, not known, or where its calibration does not reach",
     "no lens is known at this zoom"},
});

namespace detail {
constexpr bool reasons_are_in_order() {
  for (std::size_t i = 0; i < kReasons.size(); ++i)
    if (static_cast<std::size_t>(kReasons[i].reason) != i || kReasons[i].label.size() > 41) return false;
  return true;
}
static_assert(reasons_are_in_order());
}  // namespace detail

/// \param code  a Reason, or a number from another machine
constexpr std::string_view reason_sentence(std::uint32_t code) noexcept {
  return code < kReasons.size() ? kReasons[code].sentence : "unknown reason (a newer service?)";
}
constexpr std::string_view reason_sentence(Reason reason) noexcept {
  return reason_sentence(static_cast<std::uint32_t>(reason));
}
constexpr std::string_view reason_label(Reason reason) noexcept {
  return kReasons[static_cast<std::size_t>(reason)].label;
}

}  // namespace ninedot
