#pragma once
/// The running service's camera, which goes on serving it.
#include <string>

#include "config/config.h"
#include "programs/assembly/open_source.h"

namespace ninedot {

/// \param config  in the file `config_file`: the service's
/// Throws StartupError(kWorkFailed): it gives none, is not running, or runs with pictures of another size.
OpenedSource open_tapped_source(const std::string& config_file, const Config& config);

}  // namespace ninedot
