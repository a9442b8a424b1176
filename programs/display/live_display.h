#pragma once
/// The state of the running service for the person who started it with --live.
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "base/mono_time.h"
#include "programs/display/redrawn_lines.h"
#include "proto/register_codec.h"

namespace ninedot {

/// On a terminal: a table refreshed in place, four times a second. In a pipe, and on a terminal with too few rows: one
/// plain line a second, no escape codes. Threads: one caller.
class LiveDisplay {
 public:
  /// \param footer  lines that stand below the table: how to read the registers, how to end.
  LiveDisplay(std::FILE* out, std::vector<std::string> footer);

  /// Whether `show` would show anything now.
  bool is_due(MonoTime now) const noexcept;

  /// Shows when it is time to. \param clients  who is connected, one each.
  void show(const RegisterReader& registers, std::span<const std::string> clients, MonoTime now);

  /// Nobody will see it any more: the pipe's other end is closed, the disk is full.
  bool is_broken() const noexcept { return lines_.is_broken(); }

  /// Takes the table off the terminal, so that a log line can be written; the next `show` draws it again.
  void make_room();

 private:
  std::string table(const RegisterReader& registers, std::span<const std::string> clients) const;

  RedrawnLines lines_;
  std::vector<std::string> footer_;
  bool draws_;  ///< a table; else plain lines
  MonoTime shown_at_{};
};

}  // namespace ninedot
