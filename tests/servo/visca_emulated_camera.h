#pragma once
/// A camera of the EVI-D31 kind on a pseudo-terminal: two sockets, ACK and completion, motions that take their time,
/// and faults on request. It reads and writes the protocol on its own, with nothing of the driver's.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/servo/emulated_tty.h"

namespace ninedot::test {

using ViscaBytes = std::vector<std::uint8_t>;

class EmulatedViscaCamera {
 public:
  using Clock = std::chrono::steady_clock;

  /// All of these may be set at any time.
  struct Faults {
    std::atomic<bool> silent{false};           ///< hears everything, says nothing
    std::atomic<bool> noise{false};            ///< bytes that mean nothing between its packets
    std::atomic<bool> in_pieces{false};        ///< every byte on its own
    std::atomic<bool> not_executable{false};   ///< refuses every motion
    std::atomic<bool> one_motion_only{false};  ///< refuses a motion while another one runs
    std::atomic<bool> standby{false};          ///< refuses inquiries
    std::atomic<bool> lens_stuck{false};       ///< accepts a zoom and stays where it is
    std::atomic<int> lost_packets_percent{0};  ///< of what it says
  };
  Faults faults;
  std::atomic<int> cameras{1};    ///< in the chain, this one included
  std::atomic<int> address{1};    ///< of this one
  std::atomic<double> hurry{10};  ///< this many times as fast as the real one
  std::atomic<std::chrono::milliseconds> reply_delay{
      std::chrono::milliseconds(1)};      ///< of the real one: a field of the picture, 17 to 20 ms
  std::atomic<bool> at_9600_baud{false};  ///< packets take as long as on the line, both ways

  EmulatedViscaCamera() {
    thread_ = std::thread([this] { run(); });
  }
  ~EmulatedViscaCamera() {
    ends_ = true;
    thread_.join();
  }

  std::string device() const { return tty_.device(); }

  void plug() {
    const std::lock_guard lock(mutex_);
    tty_.plug();
  }
  /// As when a USB adapter is pulled out.
  void unplug() {
    const std::lock_guard lock(mutex_);
    tty_.unplug();
  }
  /// Off and on: the camera forgets everything and says so.
  void power_cycle() {
    const std::lock_guard lock(mutex_);
    sockets_ = {};
    pan_ = tilt_ = target_pan_ = target_tilt_ = zoom_ = target_zoom_ = 0;
    say({head(), 0x38, 0xFF});
  }

  /// As with its remote control.
  void zoom_by_hand(double to) {
    const std::lock_guard lock(mutex_);
    target_zoom_ = to;
  }

  double pan_steps() const { return locked(pan_); }
  double tilt_steps() const { return locked(tilt_); }
  int zoom() const { return static_cast<int>(locked(zoom_)); }
  int most_motions_at_once() const { return locked(most_motions_); }
  int buffer_was_full() const { return locked(buffer_was_full_); }
  bool is_at_rest() const {
    const std::lock_guard lock(mutex_);
    return pan_ == target_pan_ && tilt_ == target_tilt_;
  }
  std::vector<ViscaBytes> heard() const { return locked(heard_); }
  void forget_heard() {
    const std::lock_guard lock(mutex_);
    heard_.clear();
  }

 private:
  enum class Command { kNone, kMotion, kZoom };
  struct Reply {
    Clock::time_point due;
    ViscaBytes bytes;
  };

  template <typename T>
  T locked(const T& value) const {
    const std::lock_guard lock(mutex_);
    return value;
  }
  int line() const {
    const std::lock_guard lock(mutex_);
    return tty_.fd();
  }
  std::uint8_t head() const { return static_cast<std::uint8_t>(0x80 + 0x10 * address); }

  void run() {
    Clock::time_point before = Clock::now();
    while (!ends_) {
      EmulatedTty::wait(line());
      const std::lock_guard lock(mutex_);
      const Clock::time_point now = Clock::now();
      move(std::chrono::duration<double>(now - before).count() * hurry);
      before = now;
      listen();
      speak(now);
    }
  }

  void listen() {
    for (const std::uint8_t byte : tty_.take()) {
      packet_.push_back(byte);
      if (packet_.back() != 0xFF) continue;
      heard_.push_back(packet_);
      bytes_before_ = packet_.size();
      obey(packet_);
      bytes_before_ = 0;
      packet_.clear();
    }
  }

  void say(const ViscaBytes& bytes) {
    if (faults.silent || static_cast<int>(random() % 100) < faults.lost_packets_percent) return;
    const auto line =
        at_9600_baud ? std::chrono::microseconds(1042 * (bytes_before_ + bytes.size())) : std::chrono::microseconds(0);
    replies_.push_back({Clock::now() + reply_delay.load() + line, bytes});
  }
  void speak(Clock::time_point now) {
    while (!replies_.empty() && replies_.front().due <= now) {
      const ViscaBytes bytes = std::move(replies_.front().bytes);
      replies_.pop_front();
      if (faults.noise) tty_.put(ViscaBytes{0x00, 0x12, 0xFF, 0x41, 0x90, 0x50, 0x7F});
      if (!faults.in_pieces) {
        tty_.put(bytes);
        continue;
      }
      for (const std::uint8_t byte : bytes) {
        tty_.put(ViscaBytes{byte});
        std::this_thread::sleep_for(std::chrono::microseconds(300));
      }
    }
  }

  static double number_at(const ViscaBytes& packet, std::size_t at) {
    unsigned number = 0;
    for (std::size_t i = at; i < at + 4; ++i) number = number << 4U | (packet[i] & 0x0FU);
    return static_cast<std::int16_t>(number);
  }
  static void append_number(ViscaBytes& packet, double value) {
    const auto number = static_cast<std::uint16_t>(static_cast<int>(std::lround(value)));
    for (const unsigned shift : {12U, 8U, 4U, 0U}) packet.push_back(static_cast<std::uint8_t>(number >> shift & 0x0FU));
  }
  void refuse(int socket, int code) {
    say({head(), static_cast<std::uint8_t>(0x60 + socket), static_cast<std::uint8_t>(code), 0xFF});
  }

  void obey(const ViscaBytes& packet) {
    const auto is = [&](std::size_t from, const ViscaBytes& bytes) {
      return packet.size() > from + bytes.size() &&
             std::equal(bytes.begin(), bytes.end(), packet.begin() + static_cast<std::ptrdiff_t>(from));
    };
    if (is(0, {0x88, 0x30, 0x01})) return say({0x88, 0x30, static_cast<std::uint8_t>(cameras + 1), 0xFF});
    if (is(0, {0x88, 0x01, 0x00, 0x01})) {
      sockets_ = {};
      target_pan_ = pan_;
      target_tilt_ = tilt_;
      return say(packet);
    }
    if (packet.front() != 0x80 + address) return;
    if (packet.size() == 3 && packet[1] >> 4 == 0x02) return cancel(packet[1] & 0x0F);
    if (is(1, {0x09})) return answer(packet);
    if (is(1, {0x01, 0x06, 0x02}) && packet.size() == 15) return start_motion(packet);
    if (is(1, {0x01, 0x06, 0x01}) && packet.size() == 9) return stop_drive();
    if (is(1, {0x01, 0x04, 0x47}) && packet.size() == 9) return start_zoom(packet);
    refuse(0, 0x02);
  }

  void answer(const ViscaBytes& packet) {
    if (faults.standby) return refuse(0, 0x41);
    ViscaBytes reply = {head(), 0x50};
    if (packet[2] == 0x06 && packet[3] == 0x12) {
      append_number(reply, pan_);
      append_number(reply, tilt_);
    } else if (packet[2] == 0x04 && packet[3] == 0x47) {
      append_number(reply, zoom_);
    } else {
      return refuse(0, 0x02);
    }
    reply.push_back(0xFF);
    say(reply);
  }

  /// \return  the socket, 0: both are in use
  int occupy(Command command) {
    for (std::size_t i = 1; i <= 2; ++i) {
      if (sockets_[i] != Command::kNone) continue;
      sockets_[i] = command;
      say({head(), static_cast<std::uint8_t>(0x40 + i), 0xFF});
      return static_cast<int>(i);
    }
    ++buffer_was_full_;
    refuse(0, 0x03);
    return 0;
  }
  int motions() const { return static_cast<int>(std::count(sockets_.begin(), sockets_.end(), Command::kMotion)); }

  void start_motion(const ViscaBytes& packet) {
    if (faults.not_executable || (faults.one_motion_only && motions() > 0)) return refuse(0, 0x41);
    const double pan = number_at(packet, 6), tilt = number_at(packet, 10);
    if (packet[4] < 1 || packet[4] > 24 || packet[5] < 1 || packet[5] > 20 || std::abs(pan) > 880 ||
        std::abs(tilt) > 300)
      return refuse(0, 0x02);
    if (occupy(Command::kMotion) == 0) return;
    most_motions_ = std::max(most_motions_, motions());
    target_pan_ = pan;
    target_tilt_ = tilt;
    pan_speed_ = packet[4];
    tilt_speed_ = packet[5];
  }
  /// As Player's driver for the EVI-D30 found: refused while a motion to a position runs.
  void stop_drive() {
    if (motions() > 0) return refuse(0, 0x41);
    const int socket = occupy(Command::kMotion);
    if (socket != 0) complete(static_cast<std::size_t>(socket));
  }
  void start_zoom(const ViscaBytes& packet) {
    if (occupy(Command::kZoom) != 0 && !faults.lens_stuck) target_zoom_ = number_at(packet, 4);
  }
  void cancel(int socket) {
    if (socket < 1 || socket > 2 || sockets_[static_cast<std::size_t>(socket)] == Command::kNone)
      return refuse(socket, 0x05);
    sockets_[static_cast<std::size_t>(socket)] = Command::kNone;
    if (motions() == 0) {
      target_pan_ = pan_;
      target_tilt_ = tilt_;
    }
    refuse(socket, 0x04);
  }
  void complete(std::size_t socket) {
    sockets_[socket] = Command::kNone;
    say({head(), static_cast<std::uint8_t>(0x50 + socket), 0xFF});
  }

  static void approach(double& value, double target, double most) {
    value = std::abs(target - value) <= most ? target : value + std::copysign(most, target - value);
  }
  void move(double seconds) {
    approach(pan_, target_pan_, pan_speed_ * 80.0 / 24 * 8.8 * seconds);
    approach(tilt_, target_tilt_, tilt_speed_ * 50.0 / 20 * 12 * seconds);
    approach(zoom_, target_zoom_, 500 * seconds);
    for (std::size_t i = 1; i <= 2; ++i) {
      const bool moved = sockets_[i] == Command::kMotion && pan_ == target_pan_ && tilt_ == target_tilt_;
      const bool zoomed = sockets_[i] == Command::kZoom && zoom_ == target_zoom_;
      if (moved || zoomed) complete(i);
    }
  }

  std::uint32_t random() { return random_ = random_ * 1664525U + 1013904223U, random_ >> 8U; }

  mutable std::mutex mutex_;
  EmulatedTty tty_;
  std::atomic<bool> ends_{false};
  ViscaBytes packet_;
  std::size_t bytes_before_ = 0;  // of the packet that is being answered
  std::vector<ViscaBytes> heard_;
  std::deque<Reply> replies_;
  std::array<Command, 3> sockets_{};
  double pan_ = 0, tilt_ = 0, zoom_ = 0, target_pan_ = 0, target_tilt_ = 0, target_zoom_ = 0;
  double pan_speed_ = 24, tilt_speed_ = 20;
  int most_motions_ = 0, buffer_was_full_ = 0;
  std::uint32_t random_ = 1;
  std::thread thread_;
};

}  // namespace ninedot::test
