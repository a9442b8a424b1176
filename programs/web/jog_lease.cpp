#include "programs/web/jog_lease.h"

namespace ninedot {

bool JogLease::is_taken_by_another(std::string_view viewer) const noexcept {
  return (phase_ == Phase::kAsked || phase_ == Phase::kHeld) && viewer != viewer_;
}

void JogLease::hand_to(std::string_view viewer, std::string_view peer, Phase phase, MonoTime now) {
  phase_ = phase;
  viewer_ = viewer;
  peer_ = peer;
  note_.clear();
  rates_ = {};
  number_ = 0;
  heard_at_ = jogged_at_ = since_ = now;
}

bool JogLease::take(std::string_view viewer, std::string_view peer, MonoTime now) {
  // Whoever had it last is to leave it as it was first.
  if (is_taken_by_another(viewer) || phase_ == Phase::kReturning) return false;
  if (!is_holder(viewer)) hand_to(viewer, peer, Phase::kAsked, now);
  return true;
}

bool JogLease::jog(const AimRequest& request, MonoTime now) {
  if (!is_holder(request.viewer)) return false;
  heard_at_ = now;
  if (request.number <= number_) return true;  // overtaken by a newer one
  number_ = request.number;
  rates_ = request.rates;
  if (!rates_.moves()) return true;
  jogged_at_ = now;
  // A time that has not been yet was never told to anybody.
  moves_until_ = request.seen <= now ? request.seen + kReach : MonoTime{};
  return true;
}

bool JogLease::give(std::string_view viewer, MonoTime now) {
  if (!is_holder(viewer)) return false;
  give_back("", now);
  return true;
}

bool JogLease::follow(std::string_view viewer, std::string_view peer, MonoTime now) {
  if (is_taken_by_another(viewer)) return false;
  hand_to(viewer, peer, Phase::kReturning, now);
  follows_ = from_anybody_ = true;
  return true;
}

JogLease::Phase JogLease::step(MonoTime now) {
  const bool is_theirs = phase_ == Phase::kAsked || phase_ == Phase::kHeld;
  if (is_theirs && now - heard_at_ >= kAway)
    give_back("The page that had the head was heard no more.", now);
  else if (is_theirs && now - jogged_at_ >= kIdle)
    give_back("The head was given back: it had not been jogged for a minute.", now);
  else if (phase_ == Phase::kReturning && now - since_ >= kInsists)
    end("The service did not answer: the head may stand where it was left.");
  return phase_;
}

void JogLease::grant(bool followed, MonoTime now) {
  if (phase_ != Phase::kAsked) return;
  phase_ = Phase::kHeld;
  follows_ = followed;
  from_anybody_ = false;
  jogged_at_ = now;
}

void JogLease::end(std::string_view why) {
  hand_to("", "", Phase::kFree, since_);
  note_ = why;
}

void JogLease::give_back(std::string_view why, MonoTime now) {
  if (phase_ == Phase::kReturning) return;
  // Who was not given it yet has nothing to give back.
  if (phase_ != Phase::kHeld) return end(why);
  hand_to("", "", Phase::kReturning, now);
  note_ = why;
}

void JogLease::clear_up(MonoTime now) {
  hand_to("", "", Phase::kReturning, now);
  follows_ = true;
  from_anybody_ = false;
}

JogRates JogLease::rates(MonoTime now) const noexcept {
  return phase_ == Phase::kHeld && now < moves_until_ ? rates_ : JogRates{};
}

}  // namespace ninedot
