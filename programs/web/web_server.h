#pragma once
/// The page over HTTP, with GNU libmicrohttpd: one thread for all connections, bounded in number, memory and time.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "config/config.h"
#include "programs/web/access.h"
#include "programs/web/calibration_desk.h"
#include "programs/web/configuration_desk.h"
#include "programs/web/jogger.h"
#include "programs/web/map_desk.h"
#include "programs/web/recorder.h"

namespace ninedot {

struct WebServerOptions {
  WebConfig web;
  std::string tap_path;
  AccessRules rules;
  std::function<std::string()> map_json;  ///< asked each time that a page wants the map; of the server's thread
  Jogger& jogger;                         ///< must outlive the server
  Recorder& recorder;                     ///< likewise
  ConfigurationDesk& desk;                ///< likewise
  CalibrationDesk& calibrations;          ///< likewise
  MapDesk& maps;                          ///< likewise
};

/// Serves from construction to destruction.
/// Threads: the library's own for connections; `run` needs the caller's.
class WebServer {
 public:
  /// Most connections at a time, of all and of one address: sixteen viewers with the six that a browser opens.
  static constexpr unsigned kConnections = 256, kConnectionsOfOne = 128;
  /// A connection without a whole request for so long is closed, however slowly it sends.
  static constexpr std::chrono::seconds kHeadPatience{10};
  /// Nor one that takes its answer no faster: a picture is 100 kB at most, a slow line's second.
  static constexpr std::chrono::seconds kAnswerPatience{60};

  /// Throws StartupError: kWorkFailed, the address can't be used; kWrongUsage, certificate or key are none.
  explicit WebServer(WebServerOptions options);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Makes messages for those who look, until `is_over` says so; asked with each message, ten times a second where
  /// nobody wants every frame.
  void run(const std::function<bool()>& is_over);

 private:
  class Daemon;
  std::unique_ptr<Daemon> daemon_;
};

}  // namespace ninedot
