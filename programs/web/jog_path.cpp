#include "programs/web/jog_path.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

double advanced_deg(const JogAxis& axis, double at_deg, double reported_deg, double rate_deg_s, double step_s) {
  const double rate = std::clamp(rate_deg_s, -axis.fastest_deg_s, axis.fastest_deg_s);
  const double lead_deg = std::abs(rate) * std::chrono::duration<double>(JogPath::kLead).count() + JogPath::kPlay_deg;
  double next = at_deg + rate * step_s;
  // Further ahead of the head it does not get; nor does it come back, where it is ahead already.
  if (rate > 0) next = std::min(next, std::max(at_deg, reported_deg + lead_deg));
  if (rate < 0) next = std::max(next, std::min(at_deg, reported_deg - lead_deg));
  return std::clamp(next, axis.min_deg, axis.max_deg);
}

HeadDegrees within(const JogAxis& pan, const JogAxis& tilt, const HeadDegrees& at) {
  return {std::clamp(at.pan_deg, pan.min_deg, pan.max_deg), std::clamp(at.tilt_deg, tilt.min_deg, tilt.max_deg)};
}

}  // namespace

JogPath::JogPath(const JogAxis& pan, const JogAxis& tilt) : pan_(pan), tilt_(tilt) {
  for (const JogAxis& axis : {pan, tilt}) EXPECTS(axis.min_deg <= axis.max_deg && axis.fastest_deg_s >= 0);
  stand({});
}

void JogPath::stand(const HeadDegrees& at) noexcept { at_ = within(pan_, tilt_, at); }

HeadDegrees JogPath::advance(const JogRates& rates, const HeadDegrees& reported,
                             std::chrono::nanoseconds step) noexcept {
  const double step_s =
      std::chrono::duration<double>(std::clamp<std::chrono::nanoseconds>(step, {}, kLongestStep)).count();
  at_ = {advanced_deg(pan_, at_.pan_deg, reported.pan_deg, rates.pan_deg_s, step_s),
         advanced_deg(tilt_, at_.tilt_deg, reported.tilt_deg, rates.tilt_deg_s, step_s)};
  return at_;
}

}  // namespace ninedot
