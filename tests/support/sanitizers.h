/// \file
/// Which sanitizer this is built under: GCC says so by a macro, Clang (until 19) by a feature.
#pragma once

#if defined(__has_feature)
#define NINEDOT_HAS_FEATURE(x) __has_feature(x)
#else
#define NINEDOT_HAS_FEATURE(x) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || NINEDOT_HAS_FEATURE(address_sanitizer)
#define NINEDOT_ADDRESS_SANITIZER 1
#else
#define NINEDOT_ADDRESS_SANITIZER 0
#endif

#if defined(__SANITIZE_THREAD__) || NINEDOT_HAS_FEATURE(thread_sanitizer)
#define NINEDOT_THREAD_SANITIZER 1
#else
#define NINEDOT_THREAD_SANITIZER 0
#endif

namespace ninedot::test {

/// Sanitizers make everything several times slower: long tests take their counts from here.
inline constexpr bool kSanitized = NINEDOT_ADDRESS_SANITIZER || NINEDOT_THREAD_SANITIZER;

}  // namespace ninedot::test
