// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <mutex>

namespace octet {

/// @brief Keeps what was solved for stars, by their canonical form: equal stars are solved once per
/// process. Thread safe; two threads that meet a star at once may both solve it, to the same bytes.
template <typename Star, typename Solution>
class SolvedStars {
 public:
  explicit SolvedStars(Solution (*solve)(const Star&)) : solve_(solve) {}

  std::shared_ptr<const Solution> operator()(const Star& star) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const auto found = solved_.find(star);
      if (found != solved_.end()) return found->second;
    }
    auto solution = std::make_shared<const Solution>(solve_(star));
    const std::lock_guard<std::mutex> lock(mutex_);
    return solved_.emplace(star, std::move(solution)).first->second;
  }

 private:
  Solution (*solve_)(const Star&);
  std::mutex mutex_;
  std::map<Star, std::shared_ptr<const Solution>> solved_;
};

}  // namespace octet
