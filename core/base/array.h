// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace octet {

/// Allocates big blocks on huge pages where the system has them, which saves most of the time that
/// scattered reads spend on address translation; and leaves numbers uninitialised, so that memory
/// is first touched by the loop that fills it in parallel.
template <typename T>
struct ArrayAllocator {
  using value_type = T;

  ArrayAllocator() = default;
  template <typename U>
  ArrayAllocator(const ArrayAllocator<U>&) {}

  T* allocate(std::size_t n) {
    const std::size_t bytes = n * sizeof(T);
    if (bytes < kHugePage) return static_cast<T*>(::operator new(bytes));
    void* const block = ::operator new(bytes, std::align_val_t(kHugePage));
#if defined(__linux__)
    ::madvise(block, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
#endif
    return static_cast<T*>(block);
  }
  void deallocate(T* p, std::size_t n) {
    if (n * sizeof(T) < kHugePage) {
      ::operator delete(p);
    } else {
      ::operator delete(p, std::align_val_t(kHugePage));
    }
  }
  template <typename U, typename... Args>
  void construct(U* p, Args&&... args) {
    if constexpr (sizeof...(Args) == 0) {
      ::new (static_cast<void*>(p)) U;
    } else {
      ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
    }
  }
  template <typename U>
  bool operator==(const ArrayAllocator<U>&) const {
    return true;
  }
  template <typename U>
  bool operator!=(const ArrayAllocator<U>&) const {
    return false;
  }

 private:
  static constexpr std::size_t kHugePage = std::size_t{1} << 21;
};

/// A vector for big data. Note that `Array<double> a(n)` and `resize(n)` leave numbers
/// uninitialised; write `a.assign(n, 0)` for zeros.
template <typename T>
using Array = std::vector<T, ArrayAllocator<T>>;

}  // namespace octet
