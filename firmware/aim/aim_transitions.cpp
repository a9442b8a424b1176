#include "aim/aim_transitions.h"

namespace ninedot {
namespace {

constexpr bool every_pair_stands_once() {
  for (std::size_t i = 0; i < kAimTransitions.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (kAimTransitions[i].from == kAimTransitions[j].from && kAimTransitions[i].event == kAimTransitions[j].event)
        return false;
  return true;
}
static_assert(every_pair_stands_once());

constexpr bool numbers_are_in_order() {
  for (std::size_t i = 0; i < kAimStateCount; ++i)
    if (static_cast<std::size_t>(kAimStates[i].state) != i) return false;
  for (std::size_t i = 0; i < kAimEventCount; ++i)
    if (static_cast<std::size_t>(kAimEvents[i].event) != i) return false;
  return true;
}
static_assert(numbers_are_in_order());

void append(std::string& text, std::initializer_list<std::string_view> parts) {
  for (const std::string_view part : parts) text.append(part);
}

}  // namespace

std::string aim_transitions_markdown() {
  std::string text = "| state |";
  for (const AimEventWords& event : kAimEvents) append(text, {" ", event.name, " |"});
  text += "\n|---|";
  for (std::size_t i = 0; i < kAimEventCount; ++i) text += "---|";
  for (const AimStateWords& state : kAimStates) {
    if (state.state == AimState::kNone) continue;
    append(text, {"\n| ", state.name, " |"});
    for (const AimEventWords& event : kAimEvents) {
      const AimState to = next_aim_state(state.state, event.event);
      append(text, {" ", to == state.state ? std::string_view("-") : name_of(to), " |"});
    }
  }
  text += "\n\n| state | code | the head |\n|---|---|---|\n";
  for (const AimStateWords& state : kAimStates)
    append(text,
           {"| ", state.name, " | ", std::to_string(static_cast<int>(state.state)), " | ", state.sentence, " |\n"});
  text += "\n| event | happens when |\n|---|---|\n";
  for (const AimEventWords& event : kAimEvents) append(text, {"| ", event.name, " | ", event.meaning, " |\n"});
  return text;
}

}  // namespace ninedot
