#pragma once
/// What both servers' threads have in common.
#include <poll.h>

#include <functional>
#include <span>
#include <thread>

#include "base/mono_time.h"

namespace ninedot {

/// A named thread that receives no signals and never runs in real time, whatever the calling thread does.
std::thread start_server_thread(const char* name, std::function<void()> body);

/// poll() with nanoseconds, until `wake_at`. \return as poll(); -1 also when interrupted
int poll_until(std::span<pollfd> polled, MonoTime wake_at) noexcept;

}  // namespace ninedot
