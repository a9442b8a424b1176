#pragma once
/// What the software says of a strip, held against the truth.
#include <string>
#include <vector>

#include "tests/bench/trust/strip.h"

namespace ninedot::bench {

/// Of one picture.
struct Verdict {
  bool shown = false;   ///< the landmark is in the picture
  bool found = false;   ///< the software says so: something like a landmark, whatever came of it
  bool valid = false;   ///< it gives a pose and does not call it ambiguous: what a client that looks at `valid` acts on
  bool wrong = false;   ///< valid, and further from the truth than kSigmas sigma and 1 %, or there is no landmark
  bool beyond = false;  ///< valid, shown, and further from the truth than kSigmas sigma in position or in rotation
  double nees = 0;      ///< of a valid one that is not wrong: e^T C^-1 e over six degrees of freedom
  double error_m = 0;   ///< of a valid pose: of the position
  double turn_rad = 0;  ///< of a valid pose: of the rotation; multiples of 45 degrees are wrong numberings
  double error_over_bound = 0;  ///< of a valid one that is not wrong; 0: the bound is unknown
  double work_ms = 0;           ///< processor's time
};

inline constexpr double kSigmas = 6;
/// An error below this is no other reading of the picture, whatever sigma was claimed: 1 % of the distance for the
/// position, and the turn that moves the sheet as far, 0.01 rad, for the rotation.
inline constexpr double kWrong = 0.01;

/// What says of a picture that it may have colours. There are none in these.
enum class CameraKind : std::uint8_t { kGrey, kColour };

/// One verdict per shot, by `Localiser` with its defaults. Of a strip in a room by `RoomLocaliser`, with a map of one
/// black-and-white sheet: whatever looks like a landmark must be that one, and says where the camera is.
/// Threads: independent of each other.
std::vector<Verdict> judge(const Strip& strip, CameraKind camera = CameraKind::kGrey);

/// Holds one pose against the truth: fills all of the verdict from `wrong` on but the work.
struct ClaimedPose {
  std::array<double, 3> position_m{};
  std::array<double, 4> quaternion_wxyz{1, 0, 0, 0};
  std::array<double, 36> covariance{};  ///< rows of PoseEstimate::covariance
};
void compare(const ClaimedPose& claimed, const Shot& shot, Verdict& verdict);

}  // namespace ninedot::bench
