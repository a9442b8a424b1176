#pragma once
/// A head that a command moves itself: the configured one, opened as the service opens it, or that of a running
/// service.
#include <string>
#include <vector>

#include "calibrate_head/head_stops.h"
#include "config/config.h"
#include "drivers/posix/signals.h"
#include "geometry/landmark.h"
#include "programs/commands/head_news.h"

namespace ninedot {

struct LiveTourOptions {
  int columns = 7, rows = 5;    ///< of the grid of stops, 2 or more
  std::string through_service;  ///< the file of the running service's configuration; empty: none runs
  HeadNews* news = nullptr;     ///< who is told besides; null: nobody
};

struct LiveTour {
  std::vector<HeadFrame> frames;
  bool is_interrupted = false;  ///< by a signal, or nobody reads the news: the head was stopped where it was
};

/// Takes the head along its tour (head_tour.h); says before what it will do, shows on a terminal how far it is. However
/// it ends, the head is left as its TouredHead leaves it.
/// \param signals  made before this: threads begin here
/// \param landmark  out: its lengths
/// Throws StartupError: kWrongUsage where there is no head or no camera to move it before; kWorkFailed where one of
/// them can't be opened, is held by a service, or goes.
LiveTour tour_live(const Config& config, const LiveTourOptions& options, const TerminationSignals& signals,
                   LandmarkGeometry& landmark);

}  // namespace ninedot
