#include "drivers/servo/serial_line.h"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "base/baud_rates.h"
#include "base/contract.h"
#include "drivers/posix/exclusive_line.h"

namespace ninedot {
namespace {

// In the order of kServoBaudRates.
constexpr std::array<speed_t, 10> kSpeeds = {B9600,   B19200,   B38400,   B57600,   B115200,
                                             B500000, B1000000, B2000000, B3000000, B4000000};
static_assert(kSpeeds.size() == kServoBaudRates.size());

speed_t speed_of(int baud) noexcept {
  const auto* const found = std::find(kServoBaudRates.begin(), kServoBaudRates.end(), baud);
  EXPECTS(found != kServoBaudRates.end());
  return kSpeeds[static_cast<std::size_t>(found - kServoBaudRates.begin())];
}

/// \return  whether the line has taken all of it
bool set_up(int fd, speed_t speed) noexcept {
  termios line{};
  if (::tcgetattr(fd, &line) != 0) return false;
  ::cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  ::cfsetispeed(&line, speed);
  ::cfsetospeed(&line, speed);
  if (::tcsetattr(fd, TCSANOW, &line) != 0) return false;
  // tcsetattr() succeeds when any of the settings could be made.
  termios now{};
  if (::tcgetattr(fd, &now) != 0) return false;
  if (::cfgetospeed(&now) == speed && (now.c_lflag & ICANON) == 0) return true;
  errno = EINVAL;
  return false;
}

}  // namespace

Result<SerialLine> SerialLine::open(const std::string& device, int baud) noexcept {
  FileDescriptor fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd) return fail(Errc::kIo, "the serial line cannot be opened", errno);
  if (!set_up(fd.get(), speed_of(baud))) return fail(Errc::kIo, "the serial line cannot be set up", errno);
  if (!have_line_alone(fd.get())) return fail(Errc::kIo, "the serial line cannot be had alone", errno);
  (void)::tcflush(fd.get(), TCIOFLUSH);
  return SerialLine(std::move(fd));
}

SerialLine::~SerialLine() {
  if (fd_) give_line_back(fd_.get());
}

void SerialLine::drop_received() noexcept { (void)::tcflush(fd_.get(), TCIFLUSH); }

bool SerialLine::try_send(std::span<const std::uint8_t> packet) noexcept {
  // The kernel's buffer takes 4 KiB, and at most a packet is on its way: one that does not fit means a dead line.
  ssize_t sent = 0;
  do sent = ::write(fd_.get(), packet.data(), packet.size());
  while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(packet.size());
}

std::optional<std::size_t> SerialLine::receive(std::span<std::uint8_t> buffer) noexcept {
  const ssize_t got = ::read(fd_.get(), buffer.data(), buffer.size());
  if (got > 0) return static_cast<std::size_t>(got);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  // poll() promised a byte: none means that the terminal has been hung up.
  return std::nullopt;
}

}  // namespace ninedot
