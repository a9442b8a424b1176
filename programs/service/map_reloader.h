#pragma once
/// Reads the map again while the service runs: on a thread of its own, and if all of it is right, the localiser takes
/// it between two frames.
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "config/config_checks.h"
#include "outputs/output.h"
#include "pipeline/room_map.h"
#include "programs/service/service_log.h"

namespace ninedot {

/// Memory: that of one map more than the localiser has, two while it reads. Threads: the main thread alone; the thread
/// that reads belongs to it.
class MapReloader final : public Output {
 public:
  /// \param config  that the service runs with: its landmarks may change, nothing else
  /// \param keys  where they stand in it \param config_path  how problems call it
  /// \param maps  where the localiser takes them from; must outlive this, as must `log`
  MapReloader(const Config& config, const ConfigProblems& keys, std::string config_path, RoomMapHandoff& maps,
              ServiceLog& log);

  /// Asks for it and returns at once. While one is being read it is read once more afterwards, however often that was
  /// asked.
  void request();

  /// Writes down what came of it, and frees the map that the localiser has given back.
  void take(const Report& newest, bool is_new, MonoTime now) override;

 private:
  void run(const std::stop_token& stop);
  std::vector<std::string> read_again();

  Config config_;
  const ConfigProblems keys_;
  const std::string config_path_;
  RoomMapHandoff& maps_;
  ServiceLog& log_;

  std::mutex mutex_;
  std::condition_variable_any news_;
  bool is_asked_ = false;           // guarded by mutex_
  std::vector<std::string> lines_;  // guarded by mutex_: not yet written down
  std::jthread thread_;             // last: ends before anything it uses
};

}  // namespace ninedot
