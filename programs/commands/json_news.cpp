#include "programs/commands/json_news.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>

#include "base/json_text.h"
#include "drivers/posix/whole_file.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 200ms;

}  // namespace

bool JsonNews::is_due() const noexcept { return mono_now() - said_at_ >= kPeriod; }

void JsonNews::working(std::string_view what) {
  if (is_due()) say(fmt::format(R"({{"state":"solving","what":{}}})", json_text(what)));
}

void JsonNews::failed(std::string_view why) { say(fmt::format(R"({{"state":"failed","why":{}}})", json_text(why))); }

void JsonNews::say(std::string line) {
  said_at_ = mono_now();
  line += '\n';
  if (!write_all(fd_, {reinterpret_cast<const std::uint8_t*>(line.data()), line.size()}, write_to_disk))
    is_broken_ = true;
}

std::string texts_json(const std::vector<std::string>& texts) {
  std::string json;
  for (const std::string& text : texts) json.append(json.empty() ? "" : ",").append(json_text(text));
  return fmt::format("[{}]", json);
}

}  // namespace ninedot
