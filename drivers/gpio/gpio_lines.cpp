#include "drivers/gpio/gpio_lines.h"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <optional>
#include <thread>

#include "base/startup_error.h"
#include "drivers/posix/file_descriptor.h"
#include "drivers/posix/open_advice.h"

namespace ninedot {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

struct LabelAndOffset {
  std::string label;
  unsigned offset = 0;
};

std::optional<LabelAndOffset> parse_label_and_offset(const std::string& line) {
  const std::size_t colon = line.rfind(':');
  if (colon == std::string::npos || colon == 0) return std::nullopt;
  LabelAndOffset parts{line.substr(0, colon), 0};
  const char* const end = line.data() + line.size();
  const auto [stop, error] = std::from_chars(line.data() + colon + 1, end, parts.offset);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return parts;
}

[[noreturn]] void refuse_missing(const std::string& line, std::span<const GpioChip> chips) {
  if (chips.empty()) refuse(fmt::format("GPIO line '{}': this machine has no GPIO chip (/dev/gpiochip*)", line));
  std::string labels;
  for (const GpioChip& chip : chips) {
    if (chip.open_errno != 0) refuse(fmt::format("GPIO line '{}': {}", line, open_advice(chip.path, chip.open_errno)));
    labels += fmt::format("{}{} ({} lines)", labels.empty() ? "" : ", ", chip.label, chip.lines.size());
  }
  refuse(
      fmt::format("no GPIO line '{}': write a line's name or LABEL:OFFSET; chips here: {}; `gpioinfo` lists the lines",
                  line, labels));
}

class GpioOutput final : public DigitalOutput {
 public:
  explicit GpioOutput(std::unique_ptr<GpioHandle> handle) noexcept : handle_(std::move(handle)) {}
  ~GpioOutput() override { static_cast<void>(handle_->set(false)); }
  GpioOutput(const GpioOutput&) = delete;
  GpioOutput& operator=(const GpioOutput&) = delete;
  int set(bool active) noexcept override { return handle_->set(active); }

 private:
  std::unique_ptr<GpioHandle> handle_;
};

class GpioInput final : public DigitalInput {
 public:
  explicit GpioInput(std::unique_ptr<GpioHandle> handle)
      : handle_(std::move(handle)), wake_(::eventfd(0, EFD_CLOEXEC)), active_(handle_->get() != 0) {
    if (!wake_) throw StartupError(ExitStatus::kWorkFailed, "no event descriptor left for a GPIO input");
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  ~GpioInput() override {
    thread_.request_stop();
    const std::uint64_t one = 1;
    static_cast<void>(!::write(wake_.get(), &one, sizeof one));
    thread_.join();
  }
  GpioInput(const GpioInput&) = delete;
  GpioInput& operator=(const GpioInput&) = delete;
  bool is_active() const noexcept override { return active_.load(std::memory_order_relaxed); }

 private:
  void run(const std::stop_token& stop) noexcept {
    pthread_setname_np(pthread_self(), "gpio input");
    std::array<pollfd, 2> watched{{{handle_->event_fd(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
    while (!stop.stop_requested()) {
      if (::poll(watched.data(), watched.size(), -1) < 0 && errno != EINTR) break;
      // A chip that was unplugged answers with an error for good: no reason to ask it again and again.
      const bool is_gone = (watched[0].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0;
      if ((watched[0].revents & POLLIN) != 0) handle_->drop_events();
      // The level counts, not the kind of the last edge: the kernel's queue may have overflown.
      active_.store(is_gone || handle_->get() != 0, std::memory_order_relaxed);
      if (is_gone) watched[0].fd = -1;
    }
  }

  std::unique_ptr<GpioHandle> handle_;
  FileDescriptor wake_;
  std::atomic<bool> active_;
  std::jthread thread_;  // last: ends before anything it uses
};

}  // namespace

GpioRequest find_gpio_line(const GpioLineOptions& options, std::span<const GpioChip> chips) {
  const std::optional<LabelAndOffset> parts = parse_label_and_offset(options.line);
  for (const GpioChip& chip : chips)
    for (unsigned offset = 0; offset < chip.lines.size(); ++offset) {
      const GpioLine& line = chip.lines[offset];
      const bool is_meant =
          line.name == options.line || (parts && parts->label == chip.label && parts->offset == offset);
      if (!is_meant || options.line.empty()) continue;
      if (!line.consumer.empty())
        refuse(fmt::format("GPIO line '{}' is in use by '{}': stop that, or choose another line", options.line,
                           line.consumer));
      return {chip.path, offset, options.active_low, "ninedot"};
    }
  refuse_missing(options.line, chips);
}

std::unique_ptr<DigitalOutput> open_gpio_output(const GpioLineOptions& options) {
  const GpioRequest request = find_gpio_line(options, list_gpio_chips());
  std::unique_ptr<GpioHandle> handle = request_gpio_output(request, false);
  if (!handle) refuse(fmt::format("GPIO line '{}': {}", options.line, open_advice(request.chip_path, errno)));
  return std::make_unique<GpioOutput>(std::move(handle));
}

std::unique_ptr<DigitalInput> watch_gpio_input(std::unique_ptr<GpioHandle> handle) {
  return std::make_unique<GpioInput>(std::move(handle));
}

std::unique_ptr<DigitalInput> open_gpio_input(const GpioLineOptions& options) {
  const GpioRequest request = find_gpio_line(options, list_gpio_chips());
  std::unique_ptr<GpioHandle> handle = request_gpio_input(request, options.bias);
  if (!handle) refuse(fmt::format("GPIO line '{}': {}", options.line, open_advice(request.chip_path, errno)));
  return watch_gpio_input(std::move(handle));
}

}  // namespace ninedot
