#pragma once
/// poll() with a point in time instead of milliseconds.
#include <poll.h>

#include <span>

#include "base/mono_time.h"

namespace ninedot {

/// Waits until one of `polled` is ready, or until `wake_at` (MonoTime::max() = for ever); looks once where that has
/// passed. \return as poll(): -1 with errno, also when interrupted (then all revents are 0)
int poll_until(std::span<pollfd> polled, MonoTime wake_at) noexcept;

}  // namespace ninedot
