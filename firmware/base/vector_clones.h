#pragma once
/// Loops over lanes in vectors as wide as the processor has them.

/// Before a function whose loops over lanes take much of a frame's time: on x86-64 it is there twice, with the vectors
/// that each such processor has (SSE2, four floats) and with AVX2 (eight); the loader takes what the machine can run.
/// All that it calls and that can be inlined comes with it. Both round alike, for AVX2 brings no fused multiply-add, so
/// that a recording gives the same bytes on either. Nothing elsewhere, with Clang, or under sanitizers, which look at
/// code before the choice is made.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define NINEDOT_VECTOR_CLONES [[gnu::target_clones("default", "avx2"), gnu::flatten]]
#else
#define NINEDOT_VECTOR_CLONES
#endif
