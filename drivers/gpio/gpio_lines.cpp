#include "drivers/gpio/gpio_lines.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>

#include "drivers/posix/open_advice.h"
#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

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

[[noreturn]] void refuse_missing(const std::string& line, const std::optional<LabelAndOffset>& parts,
                                 std::span<const GpioChip> chips) {
  if (chips.empty())
    throw DeviceAbsent(fmt::format("GPIO line '{}': this machine has no GPIO chip (/dev/gpiochip*)", line));
  std::string labels;
  for (const GpioChip& chip : chips) {
    if (chip.open_errno != 0)
      throw DeviceAbsent(fmt::format("GPIO line '{}': {}", line, open_advice(chip.path, chip.open_errno)));
    labels += fmt::format("{}{} ({} lines)", labels.empty() ? "" : ", ", chip.label, chip.lines.size());
  }
  const std::string what =
      fmt::format("no GPIO line '{}': write a line's name or LABEL:OFFSET; chips here: {}; `gpioinfo` lists the lines",
                  line, labels);
  // The chip is there and has fewer lines: no other one of its label will come.
  const bool is_beyond =
      parts && std::ranges::any_of(chips, [&](const GpioChip& c) { return c.label == parts->label; });
  if (is_beyond || line.empty()) throw StartupError(ExitStatus::kWrongUsage, what);
  throw DeviceAbsent(what);
}

class GpioOutput final : public DigitalOutput {
 public:
  explicit GpioOutput(std::unique_ptr<GpioHandle> handle) noexcept : handle_(std::move(handle)) {}
  ~GpioOutput() override { static_cast<void>(handle_->set(false)); }
  GpioOutput(const GpioOutput&) = delete;
  GpioOutput& operator=(const GpioOutput&) = delete;
  Result<void> set(bool active) noexcept override { return handle_->set(active); }

 private:
  std::unique_ptr<GpioHandle> handle_;
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
        throw DeviceAbsent(fmt::format("GPIO line '{}' is in use by '{}': stop that, or choose another line",
                                       options.line, line.consumer));
      return {chip.path, offset, options.active_low, "ninedot"};
    }
  refuse_missing(options.line, parts, chips);
}

std::unique_ptr<DigitalOutput> open_gpio_output(const GpioLineOptions& options) {
  const GpioRequest request = find_gpio_line(options, list_gpio_chips());
  std::unique_ptr<GpioHandle> handle = request_gpio_output(request, false);
  if (!handle)
    throw DeviceAbsent(fmt::format("GPIO line '{}': {}", options.line, open_advice(request.chip_path, errno)));
  return std::make_unique<GpioOutput>(std::move(handle));
}

std::unique_ptr<GpioHandle> open_gpio_handle(const GpioLineOptions& options) {
  const GpioRequest request = find_gpio_line(options, list_gpio_chips());
  std::unique_ptr<GpioHandle> handle = request_gpio_input(request, options.bias);
  if (!handle)
    throw DeviceAbsent(fmt::format("GPIO line '{}': {}", options.line, open_advice(request.chip_path, errno)));
  return handle;
}

Result<void> LateGpioOutput::set(bool active) noexcept {
  if (!output_) {
    if (mono_now() < attempt_at_) return fail(Errc::kIo, "the GPIO line is not there", ENODEV);
    output_ = try_open(open_, problem_);
    attempt_at_ = mono_now() + backoff_.next();
    if (!output_) return fail(Errc::kIo, "the GPIO line is not there", ENODEV);
  }
  const Result<void> done = output_->set(active);
  if (done) {
    backoff_.reset();
    return done;
  }
  output_.reset();
  problem_.set(fmt::format("{} ({})", done.error().text, std::strerror(done.error().os_errno)));
  return done;
}

InhibitInput::InhibitInput(Open open, const Backoff& backoff) : open_(std::move(open)), backoff_(backoff) {
  try {
    handle_ = open_();
  } catch (const DeviceAbsent& absent) {
    problem_.set(absent.what());
  }
  if (handle_ && look(mono_now()) == Look::kLost) handle_.reset();
  thread_ = std::thread([this]() noexcept { run(); });
}

InhibitInput::~InhibitInput() {
  stop_.ring();
  thread_.join();
}

void InhibitInput::run() noexcept {
  ::pthread_setname_np(::pthread_self(), "gpio input");
  for (;;) {
    if (!handle_) handle_ = open_patiently(open_, backoff_, stop_, problem_);
    if (!handle_) return;
    // The first look does not wait for an edge.
    Look seen = look(mono_now());
    if (seen == Look::kLevel) backoff_.reset();
    while (seen == Look::kLevel) seen = look(MonoTime::max());
    if (seen == Look::kStopping) return;
    handle_.reset();
  }
}

InhibitInput::Look InhibitInput::look(MonoTime wake_at) noexcept {
  const auto lost = [this](const char* what, int error) {
    active_.store(true, std::memory_order_relaxed);
    problem_.set(fmt::format("{} ({})", what, std::strerror(error)));
    return Look::kLost;
  };
  std::array<pollfd, 2> watched{{{handle_->event_fd(), POLLIN, 0}, {stop_.get(), POLLIN, 0}}};
  // poll() passes over a descriptor that is none: nothing would ever be heard from this line.
  if (watched[0].fd < 0) return lost("the GPIO line cannot be watched", EBADF);
  if (poll_until(watched, wake_at) < 0 && errno != EINTR) return lost("the GPIO line cannot be watched", errno);
  if (watched[1].revents != 0) return Look::kStopping;
  // What a chip that was unplugged answers, from then on.
  if ((watched[0].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) return lost("the GPIO chip is gone", ENODEV);
  if (watched[0].revents != 0) handle_->drop_events();
  // The level counts, not the kind of the last edge: the kernel's queue may have overflown.
  const Result<bool> level = handle_->get();
  if (!level) return lost(level.error().text, level.error().os_errno);
  active_.store(*level, std::memory_order_relaxed);
  return Look::kLevel;
}

}  // namespace ninedot
