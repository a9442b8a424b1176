#pragma once
/// Rates of serial lines: one list for the configuration, which checks them, and for the driver, which sets them.
#include <algorithm>
#include <array>

namespace ninedot {

/// Of Linux' termios (asm-generic/termbits.h, B1200 on) those from 1200 to 921600 that libmodbus knows as well: for any
/// other it silently takes 9600. 1800 baud is left out: no adapter of today has it.
inline constexpr std::array kBaudRates = {1200,   2400,   4800,   9600,   19200,  38400, 57600,
                                          115200, 230400, 460800, 500000, 576000, 921600};

constexpr bool is_baud_rate(int baud) noexcept {
  return std::find(kBaudRates.begin(), kBaudRates.end(), baud) != kBaudRates.end();
}

/// Of the lines to a head: VISCA cameras' and smart servos' rates, as far as Linux has them (asm-generic/termbits.h).
inline constexpr std::array kServoBaudRates = {9600,   19200,   38400,   57600,   115200,
                                               500000, 1000000, 2000000, 3000000, 4000000};

constexpr bool is_servo_baud_rate(int baud) noexcept {
  return std::find(kServoBaudRates.begin(), kServoBaudRates.end(), baud) != kServoBaudRates.end();
}

}  // namespace ninedot
