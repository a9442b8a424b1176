#pragma once
/// What is said to a camera, and what its answers mean; no input or output of its own, so that time can be made up.
///
/// One packet at a time is on its way; the next one goes out when it was answered or when its time is over. A motion
/// runs in one of the camera's sockets after its ACK, and a newer one is sent without waiting for its end. What the
/// newer one does to the older depends on the camera: some change the target, some answer "not executable". After such
/// an answer the older one is cancelled first, from then on always. A third motion cancels the oldest of two.
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/mono_time.h"
#include "base/zoom_stand.h"
#include "drivers/servo/visca_options.h"
#include "drivers/servo/visca_packet.h"

namespace ninedot {

/// The newest thing asked of the head.
struct ViscaOrder {
  enum class Kind : std::uint8_t { kNone, kMove, kStop };
  Kind kind = Kind::kNone;
  ViscaPosition position;      ///< of kMove
  std::uint32_t sequence = 0;  ///< another one for each order
};

enum class ViscaProblem : std::uint8_t {
  kNone,
  kSilent,        ///< nothing that was received is an answer
  kUnreadable,    ///< bytes come, and no packets
  kNoSuchCamera,  ///< the chain has fewer cameras than the address says
  kRefused,       ///< the camera answers with an error
  kZoom,          ///< the lens does not get where it should
};

/// Memory: inside, but for the copy of the options. Threads: one at a time for all methods: main while ViscaPanTilt
/// starts, then its thread. Nothing waits.
class ViscaDialogue {
 public:
  /// \param options  within their ranges (contract)
  explicit ViscaDialogue(const ViscaOptions& options) noexcept;

  /// The line has just been opened: addresses, buffers, zoom and position first, then the newest order again.
  void begin(MonoTime now) noexcept;
  /// Newest wins; one with the sequence of the one before is the same.
  void order(const ViscaOrder& order) noexcept;
  void receive(std::span<const std::uint8_t> bytes, MonoTime now) noexcept;
  /// What must be sent now: nothing while an answer is awaited, and at rest.
  std::optional<ViscaPacket> next_packet(MonoTime now) noexcept;
  /// When to call next_packet() and is_lost() again, if nothing is received or ordered before.
  MonoTime wake_at() const noexcept;

  /// The camera has told its position since begin(), and its zoom is set.
  bool is_ready() const noexcept { return step_ == Step::kReady; }
  /// It must begin() again, best on a line newly opened.
  bool is_lost(MonoTime now) const noexcept;
  /// The newest command was refused, and none has been accepted since.
  bool is_refused() const noexcept { return refused_; }
  ViscaProblem problem(MonoTime now) const noexcept;

  /// As reported last; {0, 0} before the first time.
  const ViscaPosition& position() const noexcept { return position_; }
  /// [steps], as reported last. Asked for when the options have one.
  std::optional<int> zoom() const noexcept { return zoom_; }
  /// Where the lens stands still, by the answers since begin().
  std::optional<ZoomStand> zoom_stand() const noexcept { return zoom_answers_.stand(); }
  /// In the chain; none before they were counted.
  std::optional<int> cameras() const noexcept { return cameras_; }
  /// How many commands run in the camera, as far as is known.
  int running() const noexcept;

 private:
  enum class Step : std::uint8_t { kAddress, kClear, kZoomSet, kZoomRead, kPosition, kReady };
  enum class Awaited : std::uint8_t { kNothing, kAddress, kClear, kAck, kCancel, kPosition, kZoom };
  static constexpr std::size_t kAwaitedCount = 7, kSocketCount = 16;
  enum class Command : std::uint8_t { kNone, kMove, kStop, kZoom };
  struct Socket {
    Command command = Command::kNone;
    std::uint32_t age = 0;  // smaller: older
  };

  ViscaPacket ask(Awaited awaited, const ViscaPacket& packet, MonoTime now) noexcept;
  ViscaPacket command(Command kind, const ViscaPacket& packet, MonoTime now) noexcept;
  std::optional<ViscaPacket> next_of_start(MonoTime now) noexcept;
  std::optional<ViscaPacket> next_when_ready(MonoTime now) noexcept;
  std::optional<ViscaPacket> next_cancel(MonoTime now) noexcept;
  void answered(Awaited awaited) noexcept;

  void take(const ViscaReply& reply, MonoTime now) noexcept;
  void take_ack(int socket, MonoTime now) noexcept;
  void take_zoom(int zoom, MonoTime now) noexcept;
  void take_fault(ViscaFault fault, int socket, MonoTime now) noexcept;
  void take_command_refused(ViscaFault fault, MonoTime now) noexcept;

  std::uint32_t sockets_with(Command kind) const noexcept;
  std::uint32_t busy_sockets() const noexcept;
  std::uint32_t oldest_socket() const noexcept;
  bool is_move_running_in(int socket) const noexcept;
  bool has_to_command() const noexcept { return !done_ && order_.kind != ViscaOrder::Kind::kNone; }

  const ViscaOptions options_;
  const ViscaSpeeds speeds_;
  ViscaStream stream_;

  Step step_ = Step::kAddress;
  Awaited awaited_ = Awaited::kNothing;
  MonoTime reply_by_{}, poll_at_{}, zoom_poll_at_{}, zoom_by_{}, command_at_{};
  std::array<std::optional<MonoTime>, kAwaitedCount> unanswered_since_{};

  ViscaOrder order_;
  bool done_ = true;               // order_ was accepted
  Command sent_ = Command::kNone;  // the newest, since begin()
  std::uint32_t sent_sequence_ = 0;
  std::array<Socket, kSocketCount> sockets_{};
  std::uint32_t next_age_ = 0;
  std::uint32_t to_cancel_ = 0;  // a bit for each socket
  int cancelling_ = 0;
  bool cancels_first_ = false;  // this camera takes no motion while another one runs
  int refusals_ = 0;            // in a row
  bool refused_ = false;
  bool gave_up_ = false;
  ViscaProblem answer_ = ViscaProblem::kNone;  // what the camera's own answers say is wrong
  bool heard_bytes_ = false, heard_packets_ = false;

  ViscaPosition position_;
  std::optional<int> zoom_, cameras_;
  ZoomAnswers zoom_answers_;
};

}  // namespace ninedot
