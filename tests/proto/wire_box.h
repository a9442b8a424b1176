#pragma once
/// A source of registers that shows what a test puts into it.
#include "base/mailbox.h"
#include "proto/wire_report.h"

namespace ninedot::test {

class WireBox final : public WireSource {
 public:
  WireBox() = default;
  explicit WireBox(const WireReport& report) : reports_(report) {}
  void publish(const WireReport& report) { reports_.publish(report); }
  WireState read(MonoTime /*now*/) const noexcept override { return {reports_.read(), metrics}; }

  MetricValues metrics;  ///< to be set before the first read

 private:
  Mailbox<WireReport> reports_;
};

}  // namespace ninedot::test
