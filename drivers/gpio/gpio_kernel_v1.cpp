// libgpiod 1.6: a chip, its lines, and requests that belong to the lines.
#include <gpiod.h>

#include <array>
#include <cerrno>

#include "drivers/gpio/gpio_chip_paths.h"
#include "drivers/gpio/gpio_kernel.h"

namespace ninedot {
namespace {

struct CloseChip {
  void operator()(gpiod_chip* chip) const noexcept { gpiod_chip_close(chip); }  // gives its lines back as well
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

constexpr const char *kNotDriven = "the GPIO line cannot be driven", *kNotRead = "the GPIO line cannot be read";

class HandleV1 final : public GpioHandle {
 public:
  HandleV1(Chip chip, gpiod_line* line) noexcept : chip_(std::move(chip)), line_(line) {}
  Result<void> set(bool active) noexcept override {
    if (gpiod_line_set_value(line_, active ? 1 : 0) != 0) return fail(Errc::kIo, kNotDriven, errno);
    return {};
  }
  Result<bool> get() noexcept override {
    const int value = gpiod_line_get_value(line_);
    if (value < 0) return fail(Errc::kIo, kNotRead, errno);
    return value != 0;
  }
  int event_fd() const noexcept override { return gpiod_line_event_get_fd(line_); }
  void drop_events() noexcept override {
    std::array<gpiod_line_event, 16> events;
    static_cast<void>(gpiod_line_event_read_multiple(line_, events.data(), events.size()));
  }

 private:
  Chip chip_;
  gpiod_line* line_;
};

std::string text_or_nothing(const char* text) { return text != nullptr ? text : ""; }

std::unique_ptr<GpioHandle> request_line(const GpioRequest& request, int type, int flags, int value) {
  Chip chip(gpiod_chip_open(request.chip_path.c_str()));
  gpiod_line* const line = chip ? gpiod_chip_get_line(chip.get(), request.offset) : nullptr;
  if (line == nullptr) return nullptr;
  gpiod_line_request_config config{};
  config.consumer = request.consumer.c_str();
  config.request_type = type;
  config.flags = flags | (request.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0);
  if (gpiod_line_request(line, &config, value) != 0) return nullptr;
  return std::make_unique<HandleV1>(std::move(chip), line);
}

}  // namespace

std::vector<GpioChip> list_gpio_chips() {
  std::vector<GpioChip> chips;
  for (const std::string& path : gpio_chip_paths()) {
    GpioChip found{path, {}, {}, 0};
    if (const Chip chip{gpiod_chip_open(path.c_str())}) {
      found.label = gpiod_chip_label(chip.get());
      for (unsigned i = 0; i < gpiod_chip_num_lines(chip.get()); ++i) {
        gpiod_line* const line = gpiod_chip_get_line(chip.get(), i);
        if (line == nullptr) break;
        const bool used = gpiod_line_is_used(line);
        const std::string consumer = text_or_nothing(gpiod_line_consumer(line));
        found.lines.push_back({text_or_nothing(gpiod_line_name(line)), !used              ? ""
                                                                       : consumer.empty() ? "the kernel"
                                                                                          : consumer});
      }
    } else {
      found.open_errno = errno;
    }
    chips.push_back(std::move(found));
  }
  return chips;
}

std::unique_ptr<GpioHandle> request_gpio_output(const GpioRequest& request, bool active) {
  return request_line(request, GPIOD_LINE_REQUEST_DIRECTION_OUTPUT, 0, active ? 1 : 0);
}

std::unique_ptr<GpioHandle> request_gpio_input(const GpioRequest& request, GpioBias bias) {
  const int flags = bias == GpioBias::kPullUp     ? GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP
                    : bias == GpioBias::kPullDown ? GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN
                                                  : 0;
  return request_line(request, GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES, flags, 0);
}

}  // namespace ninedot
