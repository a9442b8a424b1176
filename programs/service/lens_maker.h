#pragma once
/// Makes lenses while the service runs: for the position of the zoom at which the localiser says its frames are, on a
/// thread of its own. The localiser takes one between two frames.
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "calibrate/zoom_table.h"
#include "outputs/output.h"
#include "pipeline/localiser.h"
#include "programs/service/service_log.h"

namespace ninedot {

/// Memory: that of two lenses more than the localiser has. Threads: the main thread alone; the thread that makes them
/// belongs to it.
class LensMaker final : public Output {
 public:
  /// \param options  of the localiser \param lenses  where it asks and takes; must outlive this, as must `log`
  LensMaker(const ZoomTable& zoom, const LocaliserOptions& options, LensExchange& lenses, ServiceLog& log);

  /// Writes down which lenses were made.
  void take(const Report& newest, bool is_new, MonoTime now) override;

 private:
  void run(const std::stop_token& stop);
  std::string make(int zoom);

  const ZoomTable zoom_;
  const LocaliserOptions options_;
  LensExchange& lenses_;
  ServiceLog& log_;

  std::mutex mutex_;
  std::vector<std::string> lines_;  // guarded by mutex_: not yet written down
  std::jthread thread_;             // last: ends before anything it uses
};

}  // namespace ninedot
