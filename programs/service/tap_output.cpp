#include "programs/service/tap_output.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>

#include "programs/tap/tap_frame.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// As often as a person sees a number change.
constexpr auto kPeriod = 100ms;

/// Upper edges of the latency bins [ns], by the formula of proto/tap_layout.h.
const std::array<std::int64_t, kTapBinCount - 1> kEdges_ns = [] {
  std::array<std::int64_t, kTapBinCount - 1> edges{};
  for (std::size_t i = 0; i < edges.size(); ++i)
    edges[i] = static_cast<std::int64_t>(1e3 * kTapFirstBin_us * std::exp2(static_cast<double>(i) / 4));
  return edges;
}();

/// Ends with 0, cut between two characters of UTF-8.
void put_text(std::string_view text, std::span<char> to) noexcept {
  std::size_t length = std::min(text.size(), to.size() - 1);
  while (length < text.size() && length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80) --length;
  std::fill(std::copy_n(text.begin(), length, to.begin()), to.end(), '\0');
}

}  // namespace

void TapObserver::observe(const Frame& frame, const Fix& fix, const FrameProcessor& by, const Report& report) noexcept {
  const auto bin = std::lower_bound(kEdges_ns.begin(), kEdges_ns.end(), report.latency.count()) - kEdges_ns.begin();
  ++frame_.latency_bins[static_cast<std::size_t>(bin)];
  const TapDemand demand = tap_.demand();
  if (demand == TapDemand::kNothing) return;
  if (demand == TapDemand::kSome && report.published_at - copied_at_ < std::chrono::nanoseconds(kTapSomePeriod_ns))
    return;
  copied_at_ = report.published_at;
  describe_frame(frame, fix, by.last_observation(), report, frame_);
  describe_search(by.failed_search(), frame_);
  tap_.publish(frame_, frame.luma, frame.chroma);
}

TapOutput::TapOutput(TapWriter& tap, ModbusServer& modbus, const RegisterCodecOptions& codec,
                     const FrameLoop& frames) noexcept
    : tap_(tap), modbus_(modbus), frames_(frames) {
  service_.position_step_mm = codec.position_step_mm;
  service_.float_low_first = codec.float_word_order == WordOrder::kLowFirst ? 1 : 0;
}

void TapOutput::take(const Report& /*newest*/, bool /*is_new*/, MonoTime now) {
  tap_.look_for_readers();
  if (tap_.demand() == TapDemand::kNothing || now - written_at_ < kPeriod) return;
  written_at_ = now;
  service_.written_at_ns = to_ns(now);
  service_.frame_loop_over = frames_.over() ? 1 : 0;
  const RegisterBlock registers = modbus_.registers();
  static_assert(kRegisterCount <= kTapRegisterCount);
  service_.register_count = kRegisterCount;
  std::copy(registers.begin(), registers.end(), service_.registers.begin());
  service_.client_count = 0;
  for (const ConnectedClient& client : modbus_.clients()) {
    if (service_.client_count == kTapClientCount) break;
    TapClient& to = service_.clients[service_.client_count++];
    put_text(client.address, to.address);
    to.requests = client.requests;
    to.connected_ns = client.connected_for.count();
    to.silent_ns = client.silent_for.count();
  }
  tap_.publish(service_);
}

void TapOutput::on_line(const std::string& line, MonoTime now) noexcept {
  TapLogLine& to = service_.log[service_.log_count++ % kTapLogCount];
  to.at_ns = to_ns(now);
  put_text(line, to.text);
}

}  // namespace ninedot
