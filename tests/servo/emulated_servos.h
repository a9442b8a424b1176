#pragma once
/// Two smart servos on a pseudo-terminal, as the makers' manuals describe them, with faults on request. It reads and
/// writes both protocols on its own, with nothing of the driver's.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/servo/emulated_tty.h"

namespace ninedot::test {

enum class ServoMaker { kDynamixel, kFeetechSts, kFeetechScs };

class EmulatedServos {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// All of these may be set at any time.
  struct Faults {
    std::atomic<bool> silent{false};             ///< hear everything, say nothing
    std::atomic<bool> deaf{false};               ///< the line's noise hits everything that they are told
    std::atomic<bool> noise{false};              ///< bytes that mean nothing before each answer
    std::atomic<bool> twice{false};              ///< every answer comes two times
    std::atomic<bool> echo{false};               ///< the adapter brings back what it sends
    std::atomic<bool> in_pieces{false};          ///< three bytes of an answer at a time
    std::atomic<bool> answers_no_writes{false};  ///< a setting of both makers'
    std::atomic<int> lost_goals{0};              ///< so many of the next packets to both servos get lost
    std::atomic<int> late_torques{0};            ///< so many of that answer come, one by one, before another one's
    std::atomic<int> lost_percent{0};            ///< of answers
    std::atomic<int> spoilt_percent{0};          ///< of answers: one bit is wrong
  };
  Faults faults;

 private:
  template <typename F>
  auto locked(F f) const {
    const std::lock_guard lock(mutex_);
    return f();
  }

 public:
  EmulatedServos(ServoMaker maker, std::vector<int> ids) : maker_(maker), ids_(std::move(ids)) {
    power_cycle();
    thread_ = std::thread([this] { run(); });
  }
  ~EmulatedServos() {
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
  /// Off and on: no force, and the middle for a goal. They stay where they are.
  void power_cycle() {
    const std::lock_guard lock(mutex_);
    for (const int id : ids_) {
      Servo& servo = servos_[id];
      servo.memory.assign(256, 0);
      if (maker_ == ServoMaker::kDynamixel) servo.memory[11] = 3;
      set_word(servo, goal(), static_cast<int>(servo.at));
      servo.supply = 120;
      servo.temperature = 31;
    }
  }

  double position(int id) const {
    return locked([&] { return servos_.at(id).at; });
  }
  void put_at(int id, double position) {
    locked([&] { servos_.at(id).at = position; });
  }
  bool has_force(int id) const {
    return locked([&] { return servos_.at(id).memory[torque()] == 1; });
  }
  int byte(int id, int address) const {
    return locked([&] { return int{servos_.at(id).memory[static_cast<std::size_t>(address)]}; });
  }
  void set_byte(int id, int address, int value) {
    locked([&] { servos_.at(id).memory[static_cast<std::size_t>(address)] = static_cast<std::uint8_t>(value); });
  }
  /// [0.1 %], sign and size as the maker writes them
  void set_load(int id, int load) {
    locked([&] { servos_.at(id).load = load; });
  }
  void set_supply(int id, int tenths_V) {
    locked([&] { servos_.at(id).supply = tenths_V; });
  }
  void set_temperature(int id, int degC) {
    locked([&] { servos_.at(id).temperature = degC; });
  }
  /// Something is wrong with it: it says so in every answer, and lets go.
  void set_alarm(int id, bool alarm) {
    locked([&] { servos_.at(id).alarm = alarm; });
  }
  /// The speed that it was told: Dynamixel's Profile Velocity, Feetech's Goal Speed.
  int speed(int id) const {
    return locked([&] { return word(servos_.at(id), maker_ == ServoMaker::kDynamixel ? 112 : 46); });
  }
  std::vector<Bytes> heard() const {
    return locked([&] { return heard_; });
  }

 private:
  struct Servo {
    Bytes memory;
    double at = 2000;
    int load = 0, supply = 120, temperature = 31;
    bool alarm = false;
  };

  std::size_t torque() const { return maker_ == ServoMaker::kDynamixel ? 64 : 40; }
  std::size_t goal() const { return maker_ == ServoMaker::kDynamixel ? 116 : 42; }
  bool high_first() const { return maker_ == ServoMaker::kFeetechScs; }
  int word(const Servo& servo, std::size_t at) const {
    const int a = servo.memory[at], b = servo.memory[at + 1];
    return high_first() ? a * 256 + b : a + b * 256;
  }
  void set_word(Servo& servo, std::size_t at, int value) const {
    const auto low = static_cast<std::uint8_t>(value % 256), high = static_cast<std::uint8_t>(value / 256 % 256);
    servo.memory[at] = high_first() ? high : low;
    servo.memory[at + 1] = high_first() ? low : high;
  }

  void run() {
    auto before = std::chrono::steady_clock::now();
    while (!ends_) {
      EmulatedTty::wait(locked([&] { return tty_.fd(); }));
      const std::lock_guard lock(mutex_);
      const auto now = std::chrono::steady_clock::now();
      const double seconds = std::chrono::duration<double>(now - before).count();
      before = now;
      for (auto& [id, servo] : servos_) move(servo, seconds);
      listen();
    }
  }
  void move(Servo& servo, double seconds) const {
    const double most = 8000 * seconds, way = word(servo, goal()) - servo.at;
    if (servo.memory[torque()] == 1 && !servo.alarm) servo.at += std::clamp(way, -most, most);
    const int at = static_cast<int>(std::lround(servo.at));
    if (maker_ == ServoMaker::kDynamixel) {
      set_word(servo, 126, servo.load & 0xFFFF);
      set_word(servo, 132, at & 0xFFFF);
      servo.memory[134] = servo.memory[135] = at < 0 ? 0xFF : 0;
      set_word(servo, 144, servo.supply);
      servo.memory[146] = static_cast<std::uint8_t>(servo.temperature);
    } else {
      set_word(servo, 56, at < 0 ? 0x8000 - at : at);
      set_word(servo, 60, servo.load);
      servo.memory[62] = static_cast<std::uint8_t>(servo.supply);
      servo.memory[63] = static_cast<std::uint8_t>(servo.temperature);
    }
  }

  void listen() {
    const Bytes bytes = tty_.take();
    if (bytes.empty()) return;
    if (faults.echo) tty_.put(bytes);
    if (faults.deaf) return;
    received_.insert(received_.end(), bytes.begin(), bytes.end());
    // What is sent comes in whole packets, one by one.
    for (std::size_t size = 0; (size = packet_size()) != 0;) {
      const Bytes packet(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
      received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
      heard_.push_back(packet);
      if (maker_ == ServoMaker::kDynamixel)
        obey_dynamixel(packet);
      else
        obey_feetech(packet);
    }
  }
  std::size_t packet_size() {
    const std::size_t header = maker_ == ServoMaker::kDynamixel ? 7 : 4;
    if (received_.size() < header) return 0;
    const std::size_t size =
        maker_ == ServoMaker::kDynamixel ? 7U + received_[5] + 256U * received_[6] : 4U + received_[3];
    return received_.size() < size ? 0 : size;
  }

  /// Polynomial division, bit by bit.
  static unsigned crc(const Bytes& bytes) {
    unsigned rest = 0;
    for (const std::uint8_t byte : bytes)
      for (int bit = 7; bit >= 0; --bit) {
        const unsigned top = (rest >> 15U & 1U) ^ (static_cast<unsigned>(byte) >> static_cast<unsigned>(bit) & 1U);
        rest = (rest << 1U & 0xFFFFU) ^ (top != 0 ? 0x8005U : 0U);
      }
    return rest;
  }
  void obey_dynamixel(const Bytes& packet) {
    const Bytes body(packet.begin(), packet.end() - 2);
    if (crc(body) != packet[packet.size() - 2] + 256U * packet.back()) return;
    Bytes p;  // parameters, without stuffing
    for (std::size_t i = 8; i < body.size(); ++i)
      if (!(i > 10 && body[i] == 0xFD && body[i - 1] == 0xFD && body[i - 2] == 0xFF && body[i - 3] == 0xFF))
        p.push_back(body[i]);
    const int address = p.size() < 2 ? 0 : p[0] + 256 * p[1];
    switch (packet[7]) {
      case 0x02:
        return read(packet[4], address, p[2] + 256 * p[3]);
      case 0x03:
        return write(packet[4], address, Bytes(p.begin() + 2, p.end()), true);
      case 0x82:
        for (std::size_t i = 4; i < p.size(); ++i) read(p[i], address, p[2] + 256 * p[3]);
        return;
      case 0x83:
        return write_both(p, address, 4, p[2]);
      default:
        return;
    }
  }
  void obey_feetech(const Bytes& packet) {
    unsigned sum = 0;
    for (std::size_t i = 2; i + 1 < packet.size(); ++i) sum += packet[i];
    if ((~sum & 0xFFU) != packet.back()) return;
    const Bytes p(packet.begin() + 5, packet.end() - 1);
    if (packet[4] == 0x02) return read(packet[2], p[0], p[1]);
    if (packet[4] == 0x03) return write(packet[2], p[0], Bytes(p.begin() + 1, p.end()), true);
    if (packet[4] == 0x83) return write_both(p, p[0], 2, p[1]);
  }
  void write_both(const Bytes& p, int address, std::size_t first, std::size_t size) {
    if (faults.lost_goals > 0) {
      --faults.lost_goals;
      return;
    }
    for (std::size_t i = first; i + size < p.size(); i += size + 1)
      write(
          p[i], address,
          Bytes(p.begin() + static_cast<std::ptrdiff_t>(i) + 1, p.begin() + static_cast<std::ptrdiff_t>(i + 1 + size)),
          false);
  }
  void read(int id, int address, int count) {
    const auto found = servos_.find(id);
    if (found == servos_.end()) return;
    for (; faults.late_torques > 0; --faults.late_torques) {
      answer(id, {1});
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    const auto begin = found->second.memory.begin() + address;
    answer(id, Bytes(begin, begin + count));
  }
  void write(int id, int address, const Bytes& bytes, bool answers) {
    const auto found = servos_.find(id);
    if (found == servos_.end()) return;
    std::copy(bytes.begin(), bytes.end(), found->second.memory.begin() + address);
    if (answers && !faults.answers_no_writes) answer(id, {});
  }
  void answer(int id, const Bytes& data) {
    const bool alarm = servos_.at(id).alarm;
    Bytes bytes;
    if (maker_ == ServoMaker::kDynamixel) {
      bytes = {0xFF,
               0xFF,
               0xFD,
               0x00,
               static_cast<std::uint8_t>(id),
               0,
               0,
               0x55,
               static_cast<std::uint8_t>(alarm ? 0x80 : 0)};
      for (const std::uint8_t byte : data) {
        bytes.push_back(byte);
        const std::size_t n = bytes.size();
        if (bytes[n - 1] == 0xFD && bytes[n - 2] == 0xFF && bytes[n - 3] == 0xFF) bytes.push_back(0xFD);
      }
      bytes[5] = static_cast<std::uint8_t>(bytes.size() - 5);
      const unsigned sum = crc(bytes);
      bytes.push_back(static_cast<std::uint8_t>(sum & 0xFFU));
      bytes.push_back(static_cast<std::uint8_t>(sum >> 8U));
    } else {
      bytes = {0xFF, 0xFF, static_cast<std::uint8_t>(id), static_cast<std::uint8_t>(data.size() + 2),
               static_cast<std::uint8_t>(alarm ? 0x20 : 0)};
      bytes.insert(bytes.end(), data.begin(), data.end());
      unsigned sum = 0;
      for (std::size_t i = 2; i < bytes.size(); ++i) sum += bytes[i];
      bytes.push_back(static_cast<std::uint8_t>(~sum & 0xFFU));
    }
    say(bytes);
  }
  void say(Bytes bytes) {
    if (faults.silent || chance(faults.lost_percent)) return;
    if (faults.noise) tty_.put(Bytes{0x00, 0xFF, 0xFF, 0x01, 0xFD, 0xFF, 0xFF});
    if (chance(faults.spoilt_percent)) bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1U << random() % 8U);
    for (int times = faults.twice ? 2 : 1; times > 0; --times) {
      if (!faults.in_pieces) {
        tty_.put(bytes);
        continue;
      }
      for (std::size_t at = 0; at < bytes.size(); at += 3) {
        tty_.put(Bytes{bytes.begin() + static_cast<std::ptrdiff_t>(at),
                       bytes.begin() + static_cast<std::ptrdiff_t>(std::min(at + 3, bytes.size()))});
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      }
    }
  }
  bool chance(int percent) { return static_cast<int>(random() % 100) < percent; }
  std::uint32_t random() { return random_ = random_ * 1664525U + 1013904223U, random_ >> 8U; }

  mutable std::mutex mutex_;
  const ServoMaker maker_;
  const std::vector<int> ids_;
  EmulatedTty tty_;
  std::atomic<bool> ends_{false};
  std::map<int, Servo> servos_;
  Bytes received_;
  std::vector<Bytes> heard_;
  std::uint32_t random_ = 1;
  std::thread thread_;
};

}  // namespace ninedot::test
