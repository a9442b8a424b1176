#pragma once
/// When a source that gives no frame has ended for good.
#include <string>

#include "base/mono_time.h"
#include "programs/assembly/open_source.h"

namespace ninedot {

/// A camera that is gone may come back, so it is given 5 s; a recording's picture that can't be read will never be.
/// \param error  of FrameSource::next \param last_frame_at  or, before the first frame, when it was opened
/// \return  why there will be none, in one line; empty: ask again
std::string why_source_failed(const OpenedSource& source, const Error& error, MonoTime last_frame_at);

}  // namespace ninedot
