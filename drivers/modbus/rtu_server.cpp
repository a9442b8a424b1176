/// The loop: bytes go to the receiver; after 3.5 characters of silence it says whether they are a request for us; a
/// torn frame gets a little longer before it is forgotten. Nothing here waits without a limit except for the first
/// byte.
#include "drivers/modbus/rtu_server.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/baud_rates.h"
#include "base/contract.h"
#include "base/startup_error.h"
#include "drivers/modbus/request.h"
#include "drivers/modbus/server_thread.h"
#include "drivers/posix/backoff.h"
#include "drivers/posix/exclusive_line.h"
#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

/// Section 2.5.1.1: above 19200 baud a fixed 1.75 ms instead of 3.5 characters.
constexpr std::chrono::microseconds kShortestSilence{1750};
/// USB adapters deliver in bursts up to 16 ms apart (FTDI's default latency timer).
constexpr std::chrono::milliseconds kTornFrameWait{20};
constexpr std::chrono::seconds kSendTimeout{1};

std::chrono::nanoseconds character_time(const ModbusRtuOptions& options) noexcept {
  const int bits = 1 + 8 + (options.parity == 'N' ? 0 : 1) + options.stop_bits;
  return std::chrono::nanoseconds(1'000'000'000LL * bits / options.baud);
}

ModbusRtuOptions checked(const ModbusRtuOptions& options) {
  EXPECTS(options.unit >= 1 && options.unit <= 247);
  // libmodbus would silently take 9600 for a rate that it does not know.
  if (!is_baud_rate(options.baud))
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{} baud is no rate of a serial line: write one of {}",
                                                            options.baud, fmt::join(kBaudRates, " ")));
  const bool parity_known = options.parity == 'N' || options.parity == 'E' || options.parity == 'O';
  if (!parity_known || options.stop_bits < 1 || options.stop_bits > 2)
    throw StartupError(ExitStatus::kWrongUsage, "the serial line's parity must be N, E or O, its stop bits 1 or 2");
  return options;
}

std::string cannot_open(const std::string& device, int error) {
  std::string advice = "check the device of [modbus.rtu]";
  if (error == ENOENT || error == ENXIO || error == ENODEV)
    advice = "connect the adapter, or correct the device of [modbus.rtu]";
  if (error == EACCES || error == EPERM) advice = "add the service's user to the group dialout";
  if (error == ENOTTY || error == EINVAL || error == EISDIR)
    advice = "this is no serial line; correct the device of [modbus.rtu]";
  return fmt::format("{}: {}; {}", device, std::strerror(error), advice);
}

}  // namespace

void check_rtu_line(const ModbusRtuOptions& options) {
  const std::string device = checked(options).device;
  struct stat status {};
  if (const int error = ::stat(device.c_str(), &status) != 0 ? errno : 0; error != 0)
    refuse_device(cannot_open(device, error), error);
  // The kernel's own word for what a device is; pseudo-terminals have none.
  std::error_code none;
  const auto subsystem = std::filesystem::read_symlink(
      fmt::format("/sys/dev/char/{}:{}/subsystem", major(status.st_rdev), minor(status.st_rdev)), none);
  if (!S_ISCHR(status.st_mode) || (!none && subsystem.filename() != "tty"))
    refuse_device(cannot_open(device, ENOTTY), ENOTTY);
  if (const int error = ::access(device.c_str(), R_OK | W_OK) != 0 ? errno : 0; error != 0)
    refuse_device(cannot_open(device, error), error);
}

void RtuServer::CloseLine::operator()(modbus_t* line) const noexcept {
  if (const int fd = modbus_get_socket(line); fd >= 0) give_line_back(fd);
  modbus_close(line);
  modbus_free(line);
}

RtuServer::Line RtuServer::open_line(const ModbusRtuOptions& options) noexcept {
  Line line(modbus_new_rtu(options.device.c_str(), options.baud, options.parity, 8, options.stop_bits));
  if (line && (modbus_connect(line.get()) != 0 || !have_line_alone(modbus_get_socket(line.get())))) {
    const int error = errno;
    line.reset();
    errno = error;
  }
  return line;
}

RtuServer::RtuServer(RegisterBank& bank, const ModbusRtuOptions& options)
    : bank_(bank),
      options_(checked(options)),
      character_time_(character_time(options)),
      frame_silence_(std::max<std::chrono::nanoseconds>(character_time_ * 7 / 2, kShortestSilence)),
      line_(open_line(options_)),
      receiver_(options.unit),
      started_at_(bank.now()) {
  if (line_)
    take_over_line();
  else
    note_absent(errno);
  thread_ = start_server_thread("modbus-rtu", [this]() noexcept { run(); });
}

RtuServer::~RtuServer() {
  stop_.ring();
  thread_.join();
}

void RtuServer::take_over_line() noexcept {
  fd_ = modbus_get_socket(line_.get());
  problem_.set("");
  bank_.counters.serial_open.store(true, std::memory_order_release);
}

void RtuServer::note_absent(int error) {
  try {
    refuse_device(cannot_open(options_.device, error), error);
  } catch (const DeviceAbsent& absent) {
    problem_.set(absent.what());
  }
}

void RtuServer::run() noexcept {
  for (;;) {
    if (!line_ && !reopen()) return;
    if (serve_until_lost() == LineState::kStopping) return;
    problem_.set(options_.device + ": the line is gone");
    bank_.counters.serial_losses.fetch_add(1, std::memory_order_relaxed);
    bank_.counters.bus_errors.fetch_add(1, std::memory_order_relaxed);
    // Last: whoever sees that the line is closed finds the loss counted and its reason given.
    bank_.counters.serial_open.store(false, std::memory_order_release);
    bank_.client_left(session_);
    session_ = {};
    receiver_.give_up();
    line_.reset();
  }
}

bool RtuServer::reopen() noexcept {
  for (Backoff backoff; !is_rung_within(stop_, backoff.next());) {
    line_ = open_line(options_);
    const int error = errno;
    if (line_) {
      take_over_line();
      return true;
    }
    problem_.set(cannot_open(options_.device, error));
  }
  return false;
}

RtuServer::LineState RtuServer::serve_until_lost() noexcept {
  MonoTime last_byte_at{};
  bool frame_is_running = false;  // bytes came, and the silence that ends their frame has not passed yet
  for (;;) {
    MonoTime wake_at = bank_.check_watchdog(session_).value_or(MonoTime::max());
    if (frame_is_running) {
      wake_at = std::min(wake_at, last_byte_at + frame_silence_);
    } else if (receiver_.has_fragment()) {
      wake_at = std::min(wake_at, last_byte_at + frame_silence_ + kTornFrameWait);
    }
    bool arrived = false;
    if (const LineState state = wait_for_bytes(wake_at, arrived); state != LineState::kGood) return state;
    const MonoTime now = bank_.now();
    if (arrived) {
      if (const LineState state = receive(); state != LineState::kGood) return state;
      last_byte_at = now;
      frame_is_running = true;
    } else if (frame_is_running && now >= last_byte_at + frame_silence_) {
      frame_is_running = false;
      if (const auto request = receiver_.end_of_frame())
        if (const LineState state = answer(*request); state != LineState::kGood) return state;
      publish_counts();
    } else if (receiver_.has_fragment() && now >= last_byte_at + frame_silence_ + kTornFrameWait) {
      receiver_.give_up();
      publish_counts();
    }
  }
}

RtuServer::LineState RtuServer::wait_for_bytes(MonoTime wake_at, bool& arrived) noexcept {
  std::array<pollfd, 2> polled = {{{stop_.get(), POLLIN, 0}, {fd_, POLLIN, 0}}};
  if (poll_until(polled, wake_at) < 0) return LineState::kGood;
  if (polled[0].revents != 0) return LineState::kStopping;
  if ((polled[1].revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) return LineState::kLost;
  arrived = polled[1].revents != 0;
  return LineState::kGood;
}

RtuServer::LineState RtuServer::receive() noexcept {
  std::array<std::uint8_t, kMaxRtuFrame> bytes;
  const ssize_t got = ::read(fd_, bytes.data(), bytes.size());
  if (got < 0) return errno == EAGAIN || errno == EINTR ? LineState::kGood : LineState::kLost;
  // poll() promised a byte: none means that the terminal has been hung up.
  if (got == 0) return LineState::kLost;
  receiver_.receive(std::span(bytes).first(static_cast<std::size_t>(got)));
  return LineState::kGood;
}

/// Two-wire adapters may bring back what we send; a written register's echo is byte for byte the request.
bool RtuServer::is_own_echo(std::span<const std::uint8_t> frame) const noexcept {
  return bank_.now() < echo_until_ && frame.size() == sent_size_ &&
         std::equal(frame.begin(), frame.end(), sent_.begin());
}

RtuServer::LineState RtuServer::answer(const RtuRequest& request) noexcept {
  if (is_own_echo(request.frame)) return LineState::kGood;
  requests_.fetch_add(1, std::memory_order_relaxed);
  bank_.counters.serial_heard_ns.store(to_ns(bank_.now()), std::memory_order_relaxed);
  PduBuffer reply;
  const std::size_t reply_size = answer_request(bank_, session_, request.pdu, reply);
  if (request.broadcast) return LineState::kGood;
  sent_[0] = options_.unit;
  std::copy_n(reply.begin(), reply_size, sent_.begin() + 1);
  const std::uint16_t crc = modbus_crc(std::span(sent_).first(1 + reply_size));
  sent_[1 + reply_size] = static_cast<std::uint8_t>(crc & 0xFFU);
  sent_[2 + reply_size] = static_cast<std::uint8_t>(crc >> 8U);
  sent_size_ = reply_size + 3;
  const LineState state = send(std::span(sent_).first(sent_size_));
  echo_until_ = bank_.now() + character_time_ * static_cast<int>(sent_size_) + 2 * frame_silence_;
  return state;
}

RtuServer::LineState RtuServer::send(std::span<const std::uint8_t> frame) noexcept {
  const MonoTime deadline = bank_.now() + kSendTimeout;
  while (!frame.empty()) {
    const ssize_t sent = ::write(fd_, frame.data(), frame.size());
    if (sent > 0) {
      frame = frame.subspan(static_cast<std::size_t>(sent));
      continue;
    }
    if (sent < 0 && errno != EAGAIN && errno != EINTR) return LineState::kLost;
    // The rest of a reply that the line does not take is of no use to anybody.
    if (bank_.now() >= deadline) {
      (void)::tcflush(fd_, TCOFLUSH);
      bank_.counters.bus_errors.fetch_add(1, std::memory_order_relaxed);
      return LineState::kGood;
    }
    std::array<pollfd, 2> polled = {{{stop_.get(), POLLIN, 0}, {fd_, POLLOUT, 0}}};
    (void)poll_until(polled, deadline);
    if (polled[0].revents != 0) return LineState::kStopping;
    if ((polled[1].revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) return LineState::kLost;
  }
  return LineState::kGood;
}

void RtuServer::publish_counts() noexcept {
  const std::uint64_t broken = receiver_.broken_frames();
  bank_.counters.bus_errors.fetch_add(broken - counted_broken_, std::memory_order_relaxed);
  bank_.counters.unreadable_frames.fetch_add(broken - counted_broken_, std::memory_order_relaxed);
  counted_broken_ = broken;
  bank_.counters.foreign_frames.store(receiver_.foreign_frames(), std::memory_order_relaxed);
}

void RtuServer::append_clients(std::vector<ConnectedClient>& clients) const {
  const std::int64_t heard_ns = bank_.counters.serial_heard_ns.load(std::memory_order_relaxed);
  if (heard_ns == 0) return;
  const MonoTime now = bank_.now();
  clients.push_back({fmt::format("{} unit {}", options_.device, options_.unit),
                     requests_.load(std::memory_order_relaxed), now - started_at_, now - mono_from_ns(heard_ns)});
}

}  // namespace ninedot
