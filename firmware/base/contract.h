#pragma once
/// Contracts: a broken one is a bug in this program, in release builds too. It aborts; the service manager restarts.
#include <cstdio>
#include <cstdlib>

namespace ninedot::detail {
[[noreturn]] inline void contract_broken(const char* condition, const char* file, int line) noexcept {
  std::fprintf(stderr, "ninedot: bug: contract '%s' broken at %s:%d\n", condition, file, line);
  std::abort();
}
}  // namespace ninedot::detail

#define EXPECTS(condition)                             \
  (static_cast<bool>(condition) ? static_cast<void>(0) \
                                : ::ninedot::detail::contract_broken(#condition, __FILE__, __LINE__))
