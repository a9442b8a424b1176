#include "drivers/posix/exclusive_line.h"

#include <sys/ioctl.h>
#include <termios.h>

namespace ninedot {

bool have_line_alone(int line) noexcept { return ::ioctl(line, TIOCEXCL) == 0; }

void give_line_back(int line) noexcept {
  // Unsent bytes would make close() wait, up to 30 s on a line whose other end is gone.
  (void)::tcflush(line, TCIOFLUSH);
  // A pseudo-terminal remembers it for as long as its other end is open.
  (void)::ioctl(line, TIOCNXCL);
}

}  // namespace ninedot
