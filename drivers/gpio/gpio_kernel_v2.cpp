// libgpiod 2.x: settings, a configuration of lines, and requests that outlive the chip they were made with.
#include <gpiod.h>

#include <cerrno>

#include "drivers/gpio/gpio_chip_paths.h"
#include "drivers/gpio/gpio_kernel.h"

namespace ninedot {
namespace {

template <auto free>
struct Free {
  template <typename Object>
  void operator()(Object* object) const noexcept {
    free(object);
  }
};
using Chip = std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Free<gpiod_chip_info_free>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Free<gpiod_line_info_free>>;
using Settings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;
using LineRequest = std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>>;
using Events = std::unique_ptr<gpiod_edge_event_buffer, Free<gpiod_edge_event_buffer_free>>;

// Taken at once; the kernel keeps as many for a line (gpio_v2_line_request.event_buffer_size, linux/gpio.h).
constexpr std::size_t kEvents = 16;
constexpr const char *kNotDriven = "the GPIO line cannot be driven", *kNotRead = "the GPIO line cannot be read";

gpiod_line_value value_of(bool active) noexcept { return active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE; }

class HandleV2 final : public GpioHandle {
 public:
  HandleV2(LineRequest request, unsigned offset)
      : request_(std::move(request)), offset_(offset), events_(gpiod_edge_event_buffer_new(kEvents)) {}
  Result<void> set(bool active) noexcept override {
    if (gpiod_line_request_set_value(request_.get(), offset_, value_of(active)) != 0)
      return fail(Errc::kIo, kNotDriven, errno);
    return {};
  }
  Result<bool> get() noexcept override {
    const gpiod_line_value value = gpiod_line_request_get_value(request_.get(), offset_);
    if (value == GPIOD_LINE_VALUE_ERROR) return fail(Errc::kIo, kNotRead, errno);
    return value == GPIOD_LINE_VALUE_ACTIVE;
  }
  int event_fd() const noexcept override { return gpiod_line_request_get_fd(request_.get()); }
  void drop_events() noexcept override {
    static_cast<void>(gpiod_line_request_read_edge_events(request_.get(), events_.get(), kEvents));
  }

 private:
  LineRequest request_;
  unsigned offset_;
  Events events_;
};

std::string text_or_nothing(const char* text) { return text != nullptr ? text : ""; }

std::unique_ptr<GpioHandle> request_line(const GpioRequest& request, gpiod_line_settings* settings) {
  const Chip chip(gpiod_chip_open(request.chip_path.c_str()));
  const LineConfig lines(gpiod_line_config_new());
  const RequestConfig config(gpiod_request_config_new());
  if (!chip || !lines || !config || settings == nullptr) return nullptr;
  gpiod_line_settings_set_active_low(settings, request.active_low);
  gpiod_request_config_set_consumer(config.get(), request.consumer.c_str());
  if (gpiod_line_config_add_line_settings(lines.get(), &request.offset, 1, settings) != 0) return nullptr;
  LineRequest line(gpiod_chip_request_lines(chip.get(), config.get(), lines.get()));
  if (!line) return nullptr;
  return std::make_unique<HandleV2>(std::move(line), request.offset);
}

}  // namespace

std::vector<GpioChip> list_gpio_chips() {
  std::vector<GpioChip> chips;
  for (const std::string& path : gpio_chip_paths()) {
    GpioChip found{path, {}, {}, 0};
    const Chip chip(gpiod_chip_open(path.c_str()));
    const ChipInfo about(chip ? gpiod_chip_get_info(chip.get()) : nullptr);
    if (about) {
      found.label = gpiod_chip_info_get_label(about.get());
      for (unsigned i = 0; i < gpiod_chip_info_get_num_lines(about.get()); ++i) {
        const LineInfo line(gpiod_chip_get_line_info(chip.get(), i));
        if (!line) break;
        const bool used = gpiod_line_info_is_used(line.get());
        const std::string consumer = text_or_nothing(gpiod_line_info_get_consumer(line.get()));
        found.lines.push_back({text_or_nothing(gpiod_line_info_get_name(line.get())), !used              ? ""
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
  const Settings settings(gpiod_line_settings_new());
  if (!settings) return nullptr;
  gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT);
  gpiod_line_settings_set_output_value(settings.get(), value_of(active));
  return request_line(request, settings.get());
}

std::unique_ptr<GpioHandle> request_gpio_input(const GpioRequest& request, GpioBias bias) {
  const Settings settings(gpiod_line_settings_new());
  if (!settings) return nullptr;
  gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT);
  gpiod_line_settings_set_edge_detection(settings.get(), GPIOD_LINE_EDGE_BOTH);
  if (bias != GpioBias::kUnchanged)
    gpiod_line_settings_set_bias(settings.get(),
                                 bias == GpioBias::kPullUp ? GPIOD_LINE_BIAS_PULL_UP : GPIOD_LINE_BIAS_PULL_DOWN);
  return request_line(request, settings.get());
}

}  // namespace ninedot
