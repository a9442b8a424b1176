#pragma once
/// From what is known inside to what other machines see: metres and radians become mm and degrees, what is not known
/// yet becomes "not a number".
#include "base/mailbox.h"
#include "proto/wire_report.h"
#include "report/health.h"
#include "report/report.h"

namespace ninedot {

/// The one translation of a report. \param output  what the pose registers carry. Memory: none. Threads: pure.
WireReport wire_report(const Report& report, const PoseOutput& output = {}) noexcept;

/// The metrics that the report and the health make known; those of the Modbus servers stay 0.
/// \param now  the moment that they are for. Memory: none. Threads: pure.
MetricValues frame_metrics(const Report& report, const Health& health, MonoTime now) noexcept;

/// The registers' source: read when a request is answered, so that no copy of a report waits anywhere.
class WireOutput final : public WireSource {
 public:
  /// Both must outlive this. \param output  what the pose registers carry
  WireOutput(const Mailbox<Report>& reports, const Mailbox<Health>& health, const PoseOutput& output = {}) noexcept
      : reports_(reports), health_(health), output_(output) {}
  /// Report and frame counters are of the same frame. Threads: any ordinary one.
  WireState read(MonoTime now) const noexcept override;

 private:
  const Mailbox<Report>& reports_;
  const Mailbox<Health>& health_;
  const PoseOutput output_;
};

}  // namespace ninedot
