#include "drivers/servo/sysfs_pwm.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <thread>
#include <vector>

#include "drivers/posix/late_device.h"
#include "drivers/posix/open_advice.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

// udev gives an exported channel to its group a moment after it appeared; two seconds are generous.
constexpr std::chrono::milliseconds kExportTakes{2000};

Result<void> try_write(const std::string& path, std::string_view text) noexcept {
  const FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file) return fail(Errc::kIo, "cannot be opened", errno);
  if (::write(file.get(), text.data(), text.size()) < 0) return fail(Errc::kIo, "cannot be written", errno);
  return {};
}

void write(const std::string& path, std::int64_t number) {
  if (const Result<void> done = try_write(path, fmt::format("{}\n", number)); !done)
    refuse_device(open_advice(path, done.error().os_errno), done.error().os_errno);
}

/// 0 where there is none.
std::int64_t number_in(const std::string& path) {
  std::int64_t number = 0;
  std::ifstream(path) >> number;
  return number;
}

bool is_folder(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
}

/// A channel that is exported already (a crash left it so) is taken over.
void export_channel(const std::string& chip_folder, const std::string& channel_folder, int channel) {
  if (!is_folder(channel_folder))
    if (const Result<void> done = try_write(chip_folder + "/export", fmt::format("{}\n", channel)); !done) {
      const int error = done.error().os_errno;
      refuse_device(error == EBUSY ? fmt::format("{}: channel {} is used by the kernel itself: choose another",
                                                 chip_folder, channel)
                                   : open_advice(chip_folder + "/export", error),
                    error);
    }
  const std::string duty = channel_folder + "/duty_cycle";
  const auto deadline = std::chrono::steady_clock::now() + kExportTakes;
  while (::access(duty.c_str(), W_OK) != 0) {
    if (std::chrono::steady_clock::now() > deadline) throw DeviceAbsent(open_advice(duty, errno));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

double us_of(std::chrono::nanoseconds pulse) noexcept { return static_cast<double>(pulse.count()) * 1e-3; }

/// The pulse to begin with. A servo that a crash left under power stands where its pulse says: it goes on from there.
std::chrono::nanoseconds first_pulse(const SysfsPanTiltOptions& options, const std::string& chip, int channel,
                                     const ServoAxis& axis, double angle_rad) {
  if (const auto running = running_pulse(options.root, chip, channel)) {
    if (!axis.output_at(axis.angle_at(us_of(*running))).limited) return *running;
  }
  return pulse_from_us(axis.output_at(angle_rad).value);
}

}  // namespace

std::optional<std::chrono::nanoseconds> running_pulse(const std::string& root, const std::string& chip, int channel) {
  const std::string folder = fmt::format("{}/pwm{}", find_pwm_chip(root, chip), channel);
  const std::int64_t pulse_ns = number_in(folder + "/duty_cycle");
  if (number_in(folder + "/enable") != 1 || pulse_ns <= 0) return std::nullopt;
  return std::chrono::nanoseconds(pulse_ns);
}

std::string find_pwm_chip(const std::string& root, const std::string& chip) {
  std::vector<std::string> others;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(root, error)) {
    const fs::path device = fs::read_symlink(entry.path() / "device", error);
    if (device.filename() == chip) return entry.path().string();
    if (!device.empty()) others.push_back(device.filename().string());
  }
  throw DeviceAbsent(fmt::format("no PWM chip '{}' in {}: {}", chip, root,
                                 others.empty() ? "there is none: check the device-tree overlay"
                                                : fmt::format("there is {}", fmt::join(others, ", "))));
}

void check_sysfs_pwm(const std::string& root, const std::string& chip, int channel) {
  const std::string folder = find_pwm_chip(root, chip);
  if (const std::int64_t count = number_in(folder + "/npwm"); channel >= count)
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("PWM chip '{}' has the channels 0 to {}, no channel {}", chip, count - 1, channel));
  const std::string channel_folder = fmt::format("{}/pwm{}", folder, channel);
  const std::string file = is_folder(channel_folder) ? channel_folder + "/duty_cycle" : folder + "/export";
  if (::access(file.c_str(), W_OK) != 0) throw DeviceAbsent(open_advice(file, errno));
}

SysfsPwm::SysfsPwm(const std::string& root, const std::string& chip, int channel, std::chrono::nanoseconds period,
                   std::chrono::nanoseconds pulse)
    : chip_folder_(find_pwm_chip(root, chip)),
      channel_folder_(fmt::format("{}/pwm{}", chip_folder_, channel)),
      channel_(channel) {
  check_sysfs_pwm(root, chip, channel);
  export_channel(chip_folder_, channel_folder_, channel);
  const std::string duty = channel_folder_ + "/duty_cycle";
  // The kernel refuses a period below the pulse that is set: the old pulse goes first. Not where the period is right
  // already: what a crash left running goes on without a gap.
  if (const std::string file = channel_folder_ + "/period"; number_in(file) != period.count()) {
    write(duty, 0);
    write(file, period.count());
  }
  duty_ = FileDescriptor(::open(duty.c_str(), O_WRONLY | O_CLOEXEC));
  if (!duty_) throw DeviceAbsent(open_advice(duty, errno));
  if (const Result<void> done = set_pulse(pulse); !done)
    refuse_device(open_advice(duty, done.error().os_errno), done.error().os_errno);
  write(channel_folder_ + "/enable", 1);
}

SysfsPwm::~SysfsPwm() {
  if (!duty_) return;
  static_cast<void>(try_write(channel_folder_ + "/enable", "0\n"));
  static_cast<void>(try_write(chip_folder_ + "/unexport", fmt::format("{}\n", channel_)));
}

Result<void> SysfsPwm::set_pulse(std::chrono::nanoseconds pulse) noexcept {
  if (pulse.count() == pulse_ns_) return {};
  std::array<char, 24> text{};
  char* const end = std::to_chars(text.data(), text.data() + text.size() - 1, pulse.count()).ptr;
  *end = '\n';
  if (::pwrite(duty_.get(), text.data(), static_cast<std::size_t>(end - text.data() + 1), 0) < 0)
    return fail(Errc::kIo, "the pulse cannot be set", errno);
  pulse_ns_ = pulse.count();
  return {};
}

SysfsPanTilt::SysfsPanTilt(const SysfsPanTiltOptions& options, const ServoAxes& axes, const HeadAngles& at)
    : axes_(axes),
      pan_(options.root, options.pan_chip, options.pan_channel, options.period,
           first_pulse(options, options.pan_chip, options.pan_channel, axes.pan, at.pan_rad)),
      tilt_(options.root, options.tilt_chip, options.tilt_channel, options.period,
            first_pulse(options, options.tilt_chip, options.tilt_channel, axes.tilt, at.tilt_rad)) {
  state_.angles = {axes.pan.angle_at(us_of(pan_.pulse())), axes.tilt.angle_at(us_of(tilt_.pulse()))};
}

void SysfsPanTilt::move_to(const HeadAngles& angles) noexcept {
  const ServoAxis::Output pan = axes_.pan.output_at(angles.pan_rad), tilt = axes_.tilt.output_at(angles.tilt_rad);
  const Result<void> pan_done = pan_.set_pulse(pulse_from_us(pan.value));
  const Result<void> tilt_done = tilt_.set_pulse(pulse_from_us(tilt.value));
  state_.limited = pan.limited || tilt.limited;
  state_.failed = !pan_done || !tilt_done;
  if (pan_done) state_.angles.pan_rad = axes_.pan.angle_at(pan.value);
  if (tilt_done) state_.angles.tilt_rad = axes_.tilt.angle_at(tilt.value);
}

}  // namespace ninedot
