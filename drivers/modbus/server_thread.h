#pragma once
/// What both servers' threads have in common.
#include <functional>
#include <thread>

namespace ninedot {

/// A named thread that receives no signals and never runs in real time, whatever the calling thread does.
std::thread start_server_thread(const char* name, std::function<void()> body);

}  // namespace ninedot
