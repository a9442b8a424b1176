#pragma once
/// What a VISCA head is told at its start.
#include <chrono>
#include <optional>
#include <string>

#include "drivers/servo/visca_evi_d31.h"
#include "drivers/servo/visca_packet.h"

namespace ninedot {

struct ViscaOptions {
  std::string device;   ///< serial port: "/dev/ttyUSB0", or better a name below /dev/serial/by-id
  int address = 1;      ///< 1..7: the camera's place in the chain, 1 is next to the computer
  int pan_speed = 24;   ///< 1..24, top speed of a motion
  int tilt_speed = 20;  ///< 1..20
  /// [steps], set at the start and after each reconnection, and read back: the calibration may hold for one zoom only.
  /// 0..kEviD31MaxZoom. None: the camera keeps what it has.
  std::optional<int> zoom;
  int zoom_tolerance = 8;  ///< [steps], >= 0; a reading this close is the zoom that was asked for (1/128 of the range)

  std::chrono::milliseconds poll_interval{100};  ///< between two questions where the head stands
  /// Between two questions where the zoom stands; none: it is asked for only after it was set.
  std::optional<std::chrono::milliseconds> zoom_interval;
  std::chrono::milliseconds reply_timeout{250};    ///< after it a packet is sent again
  std::chrono::milliseconds answer_timeout{1000};  ///< without an answer: failed, and the line is opened anew
  std::chrono::milliseconds zoom_timeout{10000};   ///< for the lens to get where it should
  std::chrono::milliseconds retry_interval{500};   ///< between two attempts at a command that the camera refuses
  std::chrono::milliseconds first_reopen_wait{100},
      longest_reopen_wait{5000};  ///< doubled from one attempt to the next
};

}  // namespace ninedot
