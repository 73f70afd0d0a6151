// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "array.h"

namespace octet {

/// @brief Keeps temporary arrays from one use to the next: fresh memory has to be cleared by the
/// system first, which costs as much as a good part of a refinement step. Thread safe.
class ScratchPool {
 public:
  /// An array on loan; goes back to the pool at the end of its scope. Contents are unspecified.
  class Loan {
   public:
    Loan(ScratchPool* pool, Array<double> array) : pool_(pool), array_(std::move(array)) {}
    Loan(Loan&& other) noexcept
        : pool_(std::exchange(other.pool_, nullptr)), array_(std::move(other.array_)) {}
    Loan& operator=(Loan&&) = delete;
    ~Loan() {
      if (pool_) pool_->giveBack(std::move(array_));
    }
    double* data() { return array_.data(); }
    const double* data() const { return array_.data(); }
    double& operator[](std::size_t i) { return array_[i]; }
    const double& operator[](std::size_t i) const { return array_[i]; }

   private:
    ScratchPool* pool_;
    Array<double> array_;
  };

  /// An array of at least `size` numbers.
  Loan take(std::size_t size) {
    Array<double> array;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      // The smallest that fits, so that big ones are there for big requests.
      auto best = free_.end();
      for (auto it = free_.begin(); it != free_.end(); ++it) {
        if (it->size() >= size && (best == free_.end() || it->size() < best->size())) best = it;
      }
      if (best != free_.end() && best->size() <= 2 * size + kSmall) {
        array = std::move(*best);
        free_.erase(best);
      }
    }
    if (array.size() < size) array.resize(size);
    return Loan(this, std::move(array));
  }

  /// Frees what is not on loan.
  void clear() {
    const std::lock_guard<std::mutex> lock(mutex_);
    free_.clear();
  }

 private:
  static constexpr std::size_t kSmall = 4096;

  void giveBack(Array<double> array) {
    const std::lock_guard<std::mutex> lock(mutex_);
    free_.push_back(std::move(array));
  }

  std::mutex mutex_;
  std::vector<Array<double>> free_;
};

}  // namespace octet
