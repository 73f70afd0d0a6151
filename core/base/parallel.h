// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace octet {

/// Calls `body(first, last)` for ranges that cover 0 <= i < count, on all threads of the current
/// oneTBB arena: for loops that keep scratch space.
template <typename Count, typename Body>
void parallelRanges(Count count, const Body& body, std::size_t grain = 1024) {
  tbb::parallel_for(
      tbb::blocked_range<Count>(0, count, grain),
      [&](const tbb::blocked_range<Count>& range) { body(range.begin(), range.end()); });
}

/// Calls `body(i)` for 0 <= i < count on all threads of the current oneTBB arena. Every i must
/// write to places of its own, so that the result does not depend on the number of threads.
template <typename Count, typename Body>
void parallelFor(Count count, const Body& body, std::size_t grain = 1024) {
  tbb::parallel_for(tbb::blocked_range<Count>(0, count, grain),
                    [&](const tbb::blocked_range<Count>& range) {
                      for (Count i = range.begin(); i != range.end(); ++i) body(i);
                    });
}

/// Stores a value that several threads may store at once, all the same.
template <typename T>
void storeRelaxed(T* place, T value) {
  __atomic_store_n(place, value, __ATOMIC_RELAXED);
}

/// Sets bits of a byte that several threads may set bits of.
inline void orRelaxed(std::uint8_t* flags, std::uint8_t bits) {
  if ((__atomic_load_n(flags, __ATOMIC_RELAXED) & bits) != bits) {
    __atomic_fetch_or(flags, bits, __ATOMIC_RELAXED);
  }
}

}  // namespace octet
