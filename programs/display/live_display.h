#pragma once
/// The state of the running service for the person who started it with --live.
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "base/mono_time.h"
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
  bool is_broken() const noexcept { return is_broken_; }

  /// Takes the table off the terminal, so that a log line can be written; the next `show` draws it again.
  void make_room();

 private:
  void draw(const RegisterReader& registers, std::span<const std::string> clients);
  bool fits(std::size_t lines) const noexcept;
  void print(std::string_view text);

  std::FILE* out_;
  std::vector<std::string> footer_;
  bool terminal_;
  bool is_broken_ = false;
  std::size_t drawn_lines_ = 0;
  MonoTime shown_at_{};
};

}  // namespace ninedot
