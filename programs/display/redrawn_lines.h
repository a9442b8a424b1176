#pragma once
/// Lines on a terminal that are drawn over themselves.
#include <cstddef>
#include <string>
#include <string_view>

namespace ninedot {

/// A terminal that can draw over what it shows: TERM=dumb can't.
bool can_redraw(int fd) noexcept;
/// Of the terminal's window; 80 where it does not say.
std::size_t columns_of(int fd) noexcept;

/// Threads: one caller.
class RedrawnLines {
 public:
  /// \param fd  open for as long as this is
  explicit RedrawnLines(int fd) noexcept;

  bool is_terminal() const noexcept { return terminal_; }
  std::size_t columns() const noexcept { return columns_of(fd_); }

  /// Draws these lines in the place of those before. \param text  each line with its end
  /// \return  false: the window has fewer rows, and nothing was drawn
  bool draw(std::string_view text);

  /// Takes the lines off the terminal, so that others can be written; the next `draw` draws them below.
  /// \return  whether there were any
  bool make_room();

  /// Plain text, waiting for nobody: whoever looks away, or has stopped the terminal, holds nobody up.
  void print(std::string_view text);

  /// Nobody will see it any more: the pipe's other end is closed, the disk is full.
  bool is_broken() const noexcept { return is_broken_; }

 private:
  bool fits(std::size_t lines) const noexcept;

  int fd_;
  bool terminal_;
  bool is_broken_ = false;
  std::size_t drawn_lines_ = 0;
};

}  // namespace ninedot
