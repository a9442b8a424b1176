#pragma once
/// The configured camera and head, opened as the service opens them, for a command that moves the head itself.
#include <string>
#include <vector>

#include "calibrate_head/head_stops.h"
#include "config/config.h"
#include "drivers/posix/signals.h"
#include "geometry/landmark.h"

namespace ninedot {

struct LiveTour {
  std::vector<HeadFrame> frames;
  bool is_interrupted = false;  ///< by a signal: the head was stopped where it was
};

/// Takes the head along its tour (head_tour.h); says before what it will do, shows on a terminal how far it is. However
/// it ends, the head is stopped then and closed, which leaves it as the service leaves it.
/// \param signals  made before this: threads begin here \param columns, rows  of the grid of stops, 2 or more
/// \param landmark  out: its lengths
/// Throws StartupError: kWrongUsage where there is no head or no camera to move it before; kWorkFailed where one of
/// them can't be opened, is held by a service, or goes.
LiveTour tour_live(const Config& config, int columns, int rows, const TerminationSignals& signals,
                   LandmarkGeometry& landmark);

}  // namespace ninedot
