#include "programs/web/head_link.h"

#include <algorithm>
#include <cerrno>

#include "base/aim_state.h"
#include "proto/register_codec.h"

namespace ninedot {
namespace {

// Up to the set-points; the rest of the map is of no interest here.
constexpr std::uint16_t kRead = reg::kClientWatchdog;
// The numbers of our commands, in turn. A command is carried out when its number is not the last one: one that a
// controller comes to by counting would make it wait for its own command in vain.
constexpr std::array<std::uint16_t, 3> kSequences{0x9D0A, 0xA9D0, 0xD09A};

std::array<std::uint16_t, 2> words_of(const HeadDegrees& to) {
  std::array<std::uint16_t, 2> words{};
  encode_value(*find_register(reg::kPanSetPoint), to.pan_deg, {}, std::span(words).first(1));
  encode_value(*find_register(reg::kTiltSetPoint), to.tilt_deg, {}, std::span(words).last(1));
  return words;
}

}  // namespace

Result<void> HeadLink::failure(const Error& error) {
  // An answer that comes late must not be taken for the next one's.
  if (error.os_errno != EBUSY) close();
  return tl::unexpected<Error>(error);
}

Result<HeadView> HeadLink::look() {
  if (!client_) {
    Result<ModbusTcpClient> client = ModbusTcpClient::connect(host_, port_, kPatience);
    if (!client) return tl::unexpected<Error>(client.error());
    client_.emplace(std::move(*client));
  }
  std::array<std::uint16_t, kRead> words{};
  std::array<std::uint16_t, 1> state{};
  // The commands last: whoever writes one after that is given way to.
  const Result<void> done =
      client_->read_registers(reg::kHeadState, state).and_then([&] { return client_->read_registers(0, words); });
  if (!done) return tl::unexpected<Error>(failure(done.error()).error());
  const RegisterReader reader(words);
  if (!reader.is_ninedot()) {
    close();
    return fail(Errc::kIo, "what answers there is no ninedotd of this version");
  }
  seen_ = words[reg::kCommandSequence];
  HeadView view;
  view.at = {reader.value(reg::kPan), reader.value(reg::kTilt)};
  view.set_points = {words[reg::kPanSetPoint], words[reg::kTiltSetPoint]};
  view.command = static_cast<Command>(words[reg::kCommand]);
  view.sequence = seen_;
  view.has_head = reader.status(status_bit::kHasHead);
  view.writes_enabled = reader.status(status_bit::kWritesEnabled);
  view.inhibited = reader.status(status_bit::kInhibited);
  view.failed = reader.status(status_bit::kServoFault);
  view.follows_by_state = follows(static_cast<AimState>(state[0]));
  if (!is_of_page(view)) next_one_ = static_cast<std::uint16_t>(seen_ + 1);
  if (left_) return view;
  left_ = {view.command, view.sequence, view.set_points};
  if (!view.writes_enabled) return view;
  constexpr std::array<std::uint16_t, 1> kYes{1};
  if (const Result<void> asked = client_->write_registers(reg::kGiveWay, kYes); !asked)
    return tl::unexpected<Error>(failure(asked.error()).error());
  return view;
}

std::uint16_t HeadLink::next_sequence() const noexcept {
  return *std::find_if(kSequences.begin(), kSequences.end(),
                       [this](std::uint16_t number) { return number != seen_ && number != next_one_; });
}

Result<void> HeadLink::command(Command command) {
  if (!client_) return fail(Errc::kIo, "no Modbus connection");
  const std::array<std::uint16_t, 2> words{static_cast<std::uint16_t>(command), next_sequence()};
  if (const Result<void> done = client_->write_registers(reg::kCommand, words); !done) return failure(done.error());
  seen_ = words[1];
  left_->command = command;
  left_->sequence = seen_;
  return {};
}

Result<void> HeadLink::point(const HeadDegrees& to) {
  if (!client_) return fail(Errc::kIo, "no Modbus connection");
  const std::array<std::uint16_t, 2> words = words_of(to);
  if (const Result<void> done = client_->write_registers(reg::kPanSetPoint, words); !done) return failure(done.error());
  left_->set_points = words;
  const Result<void> done = command(Command::kPoint);
  if (done) told_ = words;
  return done;
}

Result<void> HeadLink::follow() {
  told_.reset();
  return command(Command::kFollow);
}

bool HeadLink::has_told(const HeadDegrees& to) const noexcept { return told_ == words_of(to); }

bool HeadLink::is_overruled(const HeadView& view) const noexcept {
  return left_ && *left_ != Commanded{view.command, view.sequence, view.set_points};
}

bool HeadLink::is_of_page(const HeadView& view) noexcept {
  return view.command == Command::kPoint &&
         std::find(kSequences.begin(), kSequences.end(), view.sequence) != kSequences.end();
}

}  // namespace ninedot
