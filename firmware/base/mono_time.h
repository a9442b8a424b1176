#pragma once
/// Time inside the program: CLOCK_MONOTONIC, nanoseconds. Wall-clock time appears in logs only.
#include <chrono>
#include <cstdint>

namespace ninedot {

/// std::chrono::steady_clock is CLOCK_MONOTONIC with libstdc++ on Linux; drivers rely on it.
using MonoClock = std::chrono::steady_clock;
using MonoTime = std::chrono::time_point<MonoClock, std::chrono::nanoseconds>;

inline MonoTime mono_now() noexcept { return std::chrono::time_point_cast<std::chrono::nanoseconds>(MonoClock::now()); }
inline MonoTime mono_from_ns(std::int64_t ns) noexcept { return MonoTime(std::chrono::nanoseconds(ns)); }
inline std::int64_t to_ns(MonoTime t) noexcept { return t.time_since_epoch().count(); }

}  // namespace ninedot
