#include "drivers/servo/visca_tty.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>

namespace ninedot {
namespace {

constexpr speed_t kBaud = B9600;

/// \return  whether the line has taken all of it
bool set_up(int fd) noexcept {
  termios line{};
  if (::tcgetattr(fd, &line) != 0) return false;
  ::cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  ::cfsetispeed(&line, kBaud);
  ::cfsetospeed(&line, kBaud);
  if (::tcsetattr(fd, TCSANOW, &line) != 0) return false;
  // tcsetattr() succeeds when any of the settings could be made.
  termios now{};
  if (::tcgetattr(fd, &now) != 0) return false;
  if (::cfgetospeed(&now) == kBaud && (now.c_lflag & ICANON) == 0) return true;
  errno = EINVAL;
  return false;
}

}  // namespace

Result<ViscaTty> ViscaTty::open(const std::string& device) noexcept {
  FileDescriptor fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd) return fail(Errc::kIo, "the serial line cannot be opened", errno);
  if (!set_up(fd.get())) return fail(Errc::kIo, "the serial line cannot be set up", errno);
  // A console or a second service on the same line would eat half of the replies.
  if (::ioctl(fd.get(), TIOCEXCL) != 0) return fail(Errc::kIo, "the serial line cannot be had alone", errno);
  (void)::tcflush(fd.get(), TCIOFLUSH);
  return ViscaTty(std::move(fd));
}

ViscaTty::~ViscaTty() {
  // Unsent bytes would make close() wait, up to 30 s on a line whose other end is gone.
  if (!fd_) return;
  (void)::tcflush(fd_.get(), TCIOFLUSH);
  // A pseudo-terminal remembers it for as long as its other end is open.
  (void)::ioctl(fd_.get(), TIOCNXCL);
}

bool ViscaTty::try_send(std::span<const std::uint8_t> packet) noexcept {
  // The kernel's buffer takes 4 KiB, and at most a packet is on its way: one that does not fit means a dead line.
  ssize_t sent = 0;
  do sent = ::write(fd_.get(), packet.data(), packet.size());
  while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(packet.size());
}

std::optional<std::size_t> ViscaTty::receive(std::span<std::uint8_t> buffer) noexcept {
  const ssize_t got = ::read(fd_.get(), buffer.data(), buffer.size());
  if (got > 0) return static_cast<std::size_t>(got);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  // poll() promised a byte: none means that the terminal has been hung up.
  return std::nullopt;
}

}  // namespace ninedot
