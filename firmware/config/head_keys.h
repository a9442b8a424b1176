#pragma once
/// The keys of [pan_tilt] and its two axes.
#include <span>

#include "config/config_reference.h"

namespace ninedot {

/// A part of config_keys().
std::span<const ConfigKey> head_keys();

}  // namespace ninedot
