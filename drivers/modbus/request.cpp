/// Why not libmodbus's modbus_reply: it sends by itself, so a client that does not read its replies would block every
/// other one (or, on a non-blocking socket, lose half a reply); on a bad quantity it sleeps and empties the line. What
/// would remain of its work is the few lines below.
#include "drivers/modbus/request.h"

#include <algorithm>
#include <optional>

#include "base/contract.h"

namespace ninedot {
namespace {

constexpr std::uint16_t kMaxReadQuantity = 125, kMaxWriteQuantity = 123;

void put_16(std::uint8_t* to, std::uint16_t value) noexcept {
  to[0] = static_cast<std::uint8_t>(value >> 8U);
  to[1] = static_cast<std::uint8_t>(value & 0xFFU);
}

/// Either the exception, or the reply's size.
struct Answer {
  std::optional<ModbusException> exception;
  std::size_t size = 0;
};

Answer refuse(ModbusException exception) noexcept { return {exception, 0}; }

Answer answer_read(RegisterBank& bank, ClientSession& session, std::span<const std::uint8_t> request,
                   PduBuffer& reply) noexcept {
  if (request.size() != 5) return refuse(ModbusException::kIllegalValue);
  const std::uint16_t first = big_endian_16(request.subspan(1)), quantity = big_endian_16(request.subspan(3));
  if (quantity == 0 || quantity > kMaxReadQuantity) return refuse(ModbusException::kIllegalValue);
  if (std::size_t{first} + quantity > kRegisterCount) return refuse(ModbusException::kIllegalAddress);
  const RegisterBlock block = bank.read(session);
  reply[1] = static_cast<std::uint8_t>(2U * quantity);
  for (std::size_t i = 0; i < quantity; ++i) put_16(&reply[2 + 2 * i], block[first + i]);
  return {{}, 2U + 2U * quantity};
}

Answer answer_write_single(RegisterBank& bank, ClientSession& session, std::span<const std::uint8_t> request,
                           PduBuffer& reply) noexcept {
  if (request.size() != 5) return refuse(ModbusException::kIllegalValue);
  const std::uint16_t value = big_endian_16(request.subspan(3));
  if (const auto refused = bank.write(session, big_endian_16(request.subspan(1)), std::span(&value, 1)))
    return refuse(*refused);
  std::copy(request.begin(), request.end(), reply.begin());
  return {{}, request.size()};
}

Answer answer_write_multiple(RegisterBank& bank, ClientSession& session, std::span<const std::uint8_t> request,
                             PduBuffer& reply) noexcept {
  if (request.size() < 6) return refuse(ModbusException::kIllegalValue);
  const std::uint16_t first = big_endian_16(request.subspan(1)), quantity = big_endian_16(request.subspan(3));
  const bool counts_agree = request[5] == 2U * quantity && request.size() == 6U + 2U * quantity;
  if (quantity == 0 || quantity > kMaxWriteQuantity || !counts_agree) return refuse(ModbusException::kIllegalValue);
  std::array<std::uint16_t, kMaxWriteQuantity> values;
  for (std::size_t i = 0; i < quantity; ++i) values[i] = big_endian_16(request.subspan(6 + 2 * i));
  if (const auto refused = bank.write(session, first, std::span(values).first(quantity))) return refuse(*refused);
  std::copy_n(request.begin(), 5, reply.begin());
  return {{}, 5};
}

Answer answer_by_function(RegisterBank& bank, ClientSession& session, std::span<const std::uint8_t> request,
                          PduBuffer& reply) noexcept {
  switch (request[0]) {
    case kReadHolding:
    case kReadInput:
      return answer_read(bank, session, request, reply);
    case kWriteSingle:
      if (bank.writes_enabled()) return answer_write_single(bank, session, request, reply);
      break;
    case kWriteMultiple:
      if (bank.writes_enabled()) return answer_write_multiple(bank, session, request, reply);
      break;
    default:
      break;
  }
  return refuse(ModbusException::kIllegalFunction);
}

}  // namespace

std::size_t answer_request(RegisterBank& bank, ClientSession& session, std::span<const std::uint8_t> request,
                           PduBuffer& reply) noexcept {
  EXPECTS(!request.empty() && request.size() <= kMaxPdu);
  bank.request_arrived(session);
  reply[0] = request[0];
  const Answer answer = answer_by_function(bank, session, request, reply);
  if (!answer.exception) return answer.size;
  bank.counters.exceptions.fetch_add(1, std::memory_order_relaxed);
  reply[0] = static_cast<std::uint8_t>(request[0] | kExceptionFlag);
  reply[1] = static_cast<std::uint8_t>(*answer.exception);
  return 2;
}

}  // namespace ninedot
