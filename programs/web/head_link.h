#pragma once
/// The head as a Modbus client of the service sees and commands it, in the way of `ninedot aim`: one connection, open
/// while somebody needs it. Every call waits for the service for kPatience at most per reply, and says when none came.
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "base/result.h"
#include "drivers/modbus/client.h"
#include "programs/web/jog_path.h"
#include "proto/register_map.h"

namespace ninedot {

/// What the service says of its head.
struct HeadView {
  HeadDegrees at;
  std::array<std::uint16_t, 2> set_points{};  ///< registers 105 and 106 as they are [0.01 deg]
  Command command = Command::kNone;           ///< what was written last; whoever did
  std::uint16_t sequence = 0;                 ///< and its number
  bool has_head = false, writes_enabled = false, inhibited = false, failed = false;
  bool follows_by_state = false;  ///< it searches for the landmark or follows it, whatever `command` says
};

/// Threads: one. Memory: the connection's.
class HeadLink {
 public:
  static constexpr std::chrono::milliseconds kPatience{150};

  /// \param host  numeric address
  HeadLink(std::string host, std::uint16_t port) : host_(std::move(host)), port_(port) {}

  /// Connects first where there is no connection. \error kIo: no answer, or no ninedotd of this version
  Result<HeadView> look();
  /// After a look(). \error kIo: refused, or no answer; os_errno is EBUSY where somebody else has commanded it since:
  /// look again
  Result<void> point(const HeadDegrees& to);
  Result<void> follow();
  void close() noexcept {
    client_.reset();
    told_.reset();
    left_.reset();
  }

  /// Where point() would send the head has been said already.
  bool has_told(const HeadDegrees& to) const noexcept;
  /// Somebody else has written a command, or set-points, since the connection's first look() or what was sent last.
  bool is_overruled(const HeadView& view) const noexcept;
  /// It stands where a page sent it; this one or one of another process of ours.
  static bool is_of_page(const HeadView& view) noexcept;

 private:
  Result<void> command(Command command);
  std::uint16_t next_sequence() const noexcept;
  Result<void> failure(const Error& error);

  const std::string host_;
  const std::uint16_t port_;
  std::optional<ModbusTcpClient> client_;
  std::uint16_t seen_ = 0;      // register 101, as it is
  std::uint16_t next_one_ = 0;  // what a controller that counts by itself writes next, most likely
  std::optional<std::array<std::uint16_t, 2>> told_;
  /// Command, number and set-points as they were first found, or as they were written last.
  struct Commanded {
    Command command = Command::kNone;
    std::uint16_t sequence = 0;
    std::array<std::uint16_t, 2> set_points{};
    bool operator==(const Commanded&) const = default;
  };
  std::optional<Commanded> left_;
};

}  // namespace ninedot
