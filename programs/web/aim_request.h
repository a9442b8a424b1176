#pragma once
/// What the page's Aim view asks for, as one line of words:
///
///     take VIEWER                          the head stops and waits for this page
///     jog VIEWER NUMBER SEEN_MS PAN TILT   turn at these speeds [deg/s]; 0 0: stand, and keep the head
///     give VIEWER                          as it was before
///     follow VIEWER                        the head follows the landmark, whoever sent it elsewhere
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/mono_time.h"

namespace ninedot {

/// How fast the head is to turn. Pan is positive to the left, tilt positive upwards.
struct JogRates {
  double pan_deg_s = 0, tilt_deg_s = 0;  ///< [deg/s]
  bool moves() const noexcept { return pan_deg_s != 0 || tilt_deg_s != 0; }
};

enum class AimVerb : std::uint8_t { kTake, kJog, kGive, kFollow };

struct AimRequest {
  AimVerb verb = AimVerb::kJog;
  std::string_view viewer;   ///< Viewers::is_name; lifetime: as the text's
  std::uint32_t number = 0;  ///< of kJog: the page's own count, so that one that was overtaken is known
  MonoTime seen{};           ///< of kJog: the server's time in the newest answer that the page had when it sent this
  JogRates rates;            ///< of kJog: finite, not yet within what the head may
};

/// Nothing where the text is none of the above, to the last character.
std::optional<AimRequest> parse_aim_request(std::string_view text);

}  // namespace ninedot
