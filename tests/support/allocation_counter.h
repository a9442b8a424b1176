#pragma once
/// Counts heap calls, for the tests that prove that a path makes none.
///
/// Link `ninedot_allocation_counter` (an object library) into the test program that wants it: it takes the place of
/// malloc and its relatives in the whole process, shared libraries included; operator new arrives there too. Under the
/// address and thread sanitizers, which have that place already, it uses their hooks instead
/// (the thread sanitizer's do not tell of aligned_alloc and posix_memalign).
#include <cstdint>

namespace ninedot::test {

/// Counts the calling thread's heap calls from its construction on. Guards may be nested; each counts for itself.
/// To find the culprit, set a breakpoint on `ninedot_heap_call_seen`. Memory: none. Threads: used by its own thread.
class AllocationGuard {
 public:
  AllocationGuard() noexcept;
  ~AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;

  /// malloc, calloc, realloc, aligned_alloc, posix_memalign, memalign, operator new.
  std::uint64_t allocations() const noexcept;
  /// free and operator delete, of anything but a null pointer.
  std::uint64_t releases() const noexcept;

 private:
  std::uint64_t allocations_before_;
  std::uint64_t releases_before_;
};

}  // namespace ninedot::test
