#pragma once
/// Which page has the head, for how long, and how fast it wants it to turn: rules alone, of no clock and no wire.
///
/// A page that holds a button sends keep-alives, each with the server's time in the newest answer that it had. Motion
/// is allowed until kReach after that time, not after the keep-alive's arrival: whatever waits in a network's queues
/// has grown old there and moves nothing, so that a button that was let go stops the head by the server's own clock,
/// wherever the news of it is stuck.
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/mono_time.h"
#include "programs/web/aim_request.h"

namespace ninedot {

/// Memory: a few short texts. Threads: one at a time.
class JogLease {
 public:
  enum class Phase : std::uint8_t {
    kFree,       ///< no page has the head
    kAsked,      ///< a page wants it: whether it may is to be found out
    kHeld,       ///< a page has it
    kReturning,  ///< it had it; the head is to go back to what it did before
  };

  /// Of motion, from the answer that the page had seen. A page sends every 20 ms, so that three of them may fail; the
  /// command that was on its way takes 20 ms more, and the service's report of the head 100 ms: 200 ms in all.
  static constexpr std::chrono::milliseconds kReach{80};
  /// A page of which nothing was heard for so long has gone.
  static constexpr std::chrono::seconds kAway{5};
  /// One that does not jog for so long has forgotten that it has the head.
  static constexpr std::chrono::seconds kIdle{60};
  /// So long a service that does not answer is asked to take the head back.
  static constexpr std::chrono::seconds kInsists{10};

  /// \param peer  the page's address, for others to read
  /// \return  false: another page has it, or it is going back
  bool take(std::string_view viewer, std::string_view peer, MonoTime now);
  /// \return  false: this page does not have the head
  bool jog(const AimRequest& request, MonoTime now);
  /// The page is done: the head as it was before. \return  as jog()
  bool give(std::string_view viewer, MonoTime now);
  /// The head is to follow, whoever sent it elsewhere. \return  false: another page has it
  bool follow(std::string_view viewer, std::string_view peer, MonoTime now);

  /// What time brings about: a page that is away or idle has no head. \return  the phase from now on
  Phase step(MonoTime now);
  /// kAsked ends well. \param followed  what the head did before, and is to do afterwards
  void grant(bool followed, MonoTime now);
  /// No page has it from now on. \param why  for people; empty: as it was asked for
  void end(std::string_view why);
  /// The head is to go back; no page has it. \param why  as end()
  void give_back(std::string_view why, MonoTime now);
  /// Before the first page: one that ended in the middle of it left the head where it was, and it followed before.
  void clear_up(MonoTime now);

  /// At which speeds the head is to turn now.
  JogRates rates(MonoTime now) const noexcept;

  Phase phase() const noexcept { return phase_; }
  bool is_holder(std::string_view viewer) const noexcept {
    return (phase_ == Phase::kAsked || phase_ == Phase::kHeld) && viewer == viewer_;
  }
  /// Address of the page that has it, or wants it; empty: none.
  const std::string& peer() const noexcept { return peer_; }
  /// Why the last page has it no longer, or was not given it.
  const std::string& note() const noexcept { return note_; }
  /// Of kReturning: the head is to follow.
  bool must_follow() const noexcept { return follows_; }
  /// Of kReturning: even if it was somebody else who sent it where it is.
  bool from_anybody() const noexcept { return from_anybody_; }

 private:
  bool is_taken_by_another(std::string_view viewer) const noexcept;
  void hand_to(std::string_view viewer, std::string_view peer, Phase phase, MonoTime now);

  Phase phase_ = Phase::kFree;
  std::string viewer_, peer_, note_;
  bool follows_ = false, from_anybody_ = false;
  MonoTime heard_at_{}, jogged_at_{}, since_{};
  MonoTime moves_until_{};
  JogRates rates_;
  std::uint32_t number_ = 0;
};

}  // namespace ninedot
