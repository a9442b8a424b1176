#pragma once
/// One Modbus request answered: the protocol data unit, without TCP's header or the serial line's check sum.
///
/// Modbus Application Protocol Specification V1.1b3, sections 6.3, 6.4, 6.6, 6.12 and 7.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/modbus/register_bank.h"

namespace ninedot {

inline constexpr std::size_t kMaxPdu = 253;  ///< bytes; section 4.1: 256 of the serial line less unit and check sum
/// Function codes [1].
inline constexpr std::uint8_t kReadHolding = 3, kReadInput = 4, kWriteSingle = 6, kWriteMultiple = 16;
/// Set in a reply's function code when it is an exception; never a request.
inline constexpr std::uint8_t kExceptionFlag = 0x80;

using PduBuffer = std::array<std::uint8_t, kMaxPdu>;

/// \param request  function code and data, 1..253 bytes (contract), whatever a client sent
/// \return  bytes written to `reply`, at least 2
/// Memory: none. Time: a few microseconds; never waits for anything but another client's register write.
/// Threads: the session's (RegisterBank::read and write).
std::size_t answer_request(RegisterBank& bank, ClientSession& session, std::span<const std::uint8_t> request,
                           PduBuffer& reply) noexcept;

/// \return  the raw word [1] that the first two of `bytes` are
inline std::uint16_t big_endian_16(std::span<const std::uint8_t> bytes) noexcept {
  return static_cast<std::uint16_t>(unsigned{bytes[0]} << 8U | bytes[1]);
}

}  // namespace ninedot
