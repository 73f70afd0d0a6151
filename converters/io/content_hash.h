// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace octet {

/// @brief A tag of 128 bits for some content: two FNV-1a sums over eight bytes at a time. It tells
/// contents apart; it does not withstand who wants two to be alike.
class ContentHash {
 public:
  void add(std::uint64_t word) {
    std::uint64_t& sum = sums_[count_++ & 1];
    sum = (sum ^ word) * 0x100000001b3ull;
    sum ^= sum >> 29;
  }
  void add(double x) {
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    add(bits);
  }
  template <typename Integer, typename = std::enable_if_t<std::is_integral_v<Integer>>>
  void add(Integer x) {
    add(static_cast<std::uint64_t>(x));
  }
  void add(std::string_view text) {
    add(text.size());
    for (; !text.empty(); text.remove_prefix(std::min<std::size_t>(8, text.size()))) {
      std::uint64_t word = 0;
      std::memcpy(&word, text.data(), std::min<std::size_t>(8, text.size()));
      add(word);
    }
  }

  /// The tag, in 32 hexadecimal digits.
  std::string digits() const {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string text;
    for (const std::uint64_t sum : sums_) {
      for (int bits = 0; bits < 64; bits += 4) text += kDigits[sum >> bits & 15];
    }
    return text;
  }

 private:
  std::uint64_t sums_[2] = {0xcbf29ce484222325ull, 0x84222325cbf29ce4ull};
  std::uint64_t count_ = 0;
};

}  // namespace octet
