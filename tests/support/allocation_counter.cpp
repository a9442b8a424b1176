// Two ways in. Without a sanitizer this file defines malloc and its relatives; a program's own definition wins over the
// C library's for every caller in the process (ELF symbol interposition), and glibc offers its own under other names
// (glibc manual, "Replacing malloc"). With the address or thread sanitizer their hooks call us. Counters are per thread
// and of the initial-exec kind, so that reaching them never allocates.
#include "tests/support/allocation_counter.h"

#include "tests/support/sanitizers.h"

#if NINEDOT_ADDRESS_SANITIZER || NINEDOT_THREAD_SANITIZER
#define NINEDOT_SANITIZER_HOOKS 1
#endif

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#ifdef NINEDOT_SANITIZER_HOOKS
// As in sanitizer/allocator_interface.h, which Debian packages with Clang alone.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*, std::size_t),
                                                         void (*free_hook)(const volatile void*));
#endif

extern "C" {
/// Called at every counted call: somewhere to put a breakpoint.
[[gnu::noinline]] void ninedot_heap_call_seen() noexcept;
void ninedot_heap_call_seen() noexcept { asm volatile(""); }
}

namespace {

struct HeapCalls {
  std::uint64_t allocations = 0;
  std::uint64_t releases = 0;
  int guards = 0;
};
[[gnu::tls_model("initial-exec")]] thread_local HeapCalls heap_calls;

void count_allocation() noexcept {
  if (heap_calls.guards == 0) return;
  ++heap_calls.allocations;
  ninedot_heap_call_seen();
}

void count_release(const volatile void* memory) noexcept {
  if (heap_calls.guards == 0 || memory == nullptr) return;
  ++heap_calls.releases;
  ninedot_heap_call_seen();
}

}  // namespace

#ifdef NINEDOT_SANITIZER_HOOKS

namespace {
const int hooks_installed =
    __sanitizer_install_malloc_and_free_hooks([](const volatile void*, std::size_t) { count_allocation(); },
                                              [](const volatile void* memory) { count_release(memory); });
}  // namespace

#else

extern "C" {
void* __libc_malloc(std::size_t) noexcept;
void* __libc_calloc(std::size_t, std::size_t) noexcept;
void* __libc_realloc(void*, std::size_t) noexcept;
void* __libc_memalign(std::size_t, std::size_t) noexcept;
void __libc_free(void*) noexcept;

void* malloc(std::size_t bytes) noexcept {
  count_allocation();
  return __libc_malloc(bytes);
}

void* calloc(std::size_t count, std::size_t bytes) noexcept {
  count_allocation();
  return __libc_calloc(count, bytes);
}

void* realloc(void* memory, std::size_t bytes) noexcept {
  count_allocation();
  return __libc_realloc(memory, bytes);
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  count_allocation();
  return __libc_memalign(alignment, bytes);
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  count_allocation();
  return __libc_memalign(alignment, bytes);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) noexcept {
  count_allocation();
  if (alignment % sizeof(void*) != 0 || alignment == 0 || (alignment & (alignment - 1)) != 0) return EINVAL;
  void* const got = __libc_memalign(alignment, bytes);
  if (got == nullptr) return ENOMEM;
  *memory = got;
  return 0;
}

void free(void* memory) noexcept {
  count_release(memory);
  __libc_free(memory);
}
}

#endif

namespace ninedot::test {

AllocationGuard::AllocationGuard() noexcept
    : allocations_before_(heap_calls.allocations), releases_before_(heap_calls.releases) {
#ifdef NINEDOT_SANITIZER_HOOKS
  if (hooks_installed == 0) std::abort();  // a guard that counts nothing would pass every test
#endif
  ++heap_calls.guards;
}

AllocationGuard::~AllocationGuard() { --heap_calls.guards; }

std::uint64_t AllocationGuard::allocations() const noexcept { return heap_calls.allocations - allocations_before_; }
std::uint64_t AllocationGuard::releases() const noexcept { return heap_calls.releases - releases_before_; }

}  // namespace ninedot::test
