#include "programs/service/device_identity.h"

#include <algorithm>
#include <string_view>

namespace ninedot {
namespace {

/// "1.20.300", as the build has it.
constexpr std::array<std::uint16_t, 3> numbers_of(std::string_view version) noexcept {
  std::array<std::uint16_t, 3> numbers{};
  std::size_t at = 0;
  for (const char c : version) {
    if (c == '.' && at + 1 < numbers.size())
      ++at;
    else if (c >= '0' && c <= '9')
      numbers[at] = static_cast<std::uint16_t>(10 * numbers[at] + (c - '0'));
  }
  return numbers;
}
static_assert(numbers_of("1.20.300") == std::array<std::uint16_t, 3>{1, 20, 300});

}  // namespace

DeviceIdentity device_identity(const BoardIdentity& board) {
  DeviceIdentity identity;
  identity.version = numbers_of(NINEDOT_VERSION);
  const std::size_t length = std::min(board.serial.size(), identity.board_serial.size());
  std::copy_n(board.serial.end() - static_cast<std::ptrdiff_t>(length), length, identity.board_serial.begin());
  return identity;
}

}  // namespace ninedot
