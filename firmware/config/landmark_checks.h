#pragma once
/// What the [[landmarks]] must fulfil together, wherever they stand.
#include "config/config_checks.h"

namespace ninedot {

/// Repeated identities; codes that are none, or that can't be told from another one of the map or from their own turns
/// (world/landmark_codes.h: kLeastCodeDistance; black-and-white ones are told apart by their places); places that are
/// said in two ways or by halves, and two sheets in one place. 1000 landmarks take 0.1 s with their reading.
/// \param config  its landmarks, and the geometry of their sheets
/// \param problems  knows the lines of the file that the landmarks stand in
void check_landmarks(const Config& config, ConfigProblems& problems);

/// A robot has no place in a world in which no landmark has one, and a head follows none that is not there. \param
/// config  with its landmarks \param problems  knows the lines of the configuration
void check_outputs(const Config& config, ConfigProblems& problems);

}  // namespace ninedot
