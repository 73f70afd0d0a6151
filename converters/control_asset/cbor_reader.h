// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <istream>
#include <string>
#include <utility>
#include <vector>

#include <octet/core/base/error.h>

namespace octet {

/// @brief Reads one CBOR item (RFC 8949), as far as JSON has a counterpart for it, and reports it
/// to `Events`, which has the members of nlohmann::json_sax.
///
/// Made for files that nobody vouches for, which a general reader is not: it does not recurse,
/// takes no memory on the word of a claimed length, and keeps the sign of numbers below -2^63.
template <typename Events>
class CborReader {
 public:
  /// @param kind  what messages call the document: "control asset"
  CborReader(std::istream* in, Events* events, std::string kind)
      : in_(*in->rdbuf()), events_(*events), kind_(std::move(kind)) {}

  /// Reads the whole stream.
  /// @throws InputError with the number of the byte, counted from 1; what `Events` throws.
  void run() {
    skipSelfDescription();
    item();
    while (!open_.empty()) {
      Container& top = open_.back();
      const bool ended = top.counted ? top.left == 0 : in_.sgetc() == kBreak;
      if (ended) {
        close();
        continue;
      }
      --top.left;
      if (top.map) {
        auto name = text();
        events_.key(name);
      }
      item();
    }
    if (in_.sgetc() != kEnd) fail("the file goes on after the document's end", 1);
  }

 private:
  static constexpr int kEnd = std::char_traits<char>::eof(), kBreak = 0xff;
  /// Additional information of an item's first byte.
  static constexpr int kIndefinite = 31;

  struct Container {
    bool map, counted;
    std::uint64_t left;
  };

  [[noreturn]] void fail(const std::string& reason, int ahead = 0) const {
    throw InputError("byte " + std::to_string(position_ + ahead), reason);
  }

  [[noreturn]] void refuse(const std::string& what) const {
    fail(what + " are not part of a " + kind_);
  }

  int get() {
    const int c = in_.sbumpc();
    ++position_;
    if (c == kEnd) fail("the file ends inside the document");
    return c;
  }

  /// Tag 55799 in front, "this is CBOR".
  void skipSelfDescription() {
    if (in_.sgetc() != 0xd9) return;
    get();
    if (get() != 0xd9 || get() != 0xf7) refuse("tags");
  }

  std::uint64_t bigEndian(int bytes) {
    std::uint64_t x = 0;
    while (bytes-- > 0) x = x << 8 | static_cast<std::uint64_t>(get());
    return x;
  }

  std::uint64_t argument(int info) {
    if (info < 24) return static_cast<std::uint64_t>(info);
    if (info > 27) fail("is no CBOR: a number or length of unknown size");
    return bigEndian(1 << (info - 24));
  }

  void item() {
    const int first = get(), info = first & 31;
    switch (first >> 5) {
      case 0:
        events_.number(static_cast<double>(argument(info)));
        break;
      case 1:
        events_.number(-1.0 - static_cast<double>(argument(info)));
        break;
      case 2:
        refuse("byte strings");
      case 3: {
        auto characters = textAfter(first);
        events_.string(characters);
        break;
      }
      case 4:
      case 5:
        open(first >> 5 == 5, info);
        break;
      case 6:
        refuse("tags");
      default:
        simple(info);
    }
  }

  void open(bool map, int info) {
    const bool counted = info != kIndefinite;
    open_.push_back({map, counted, counted ? argument(info) : 0});
    map ? events_.start_object(0) : events_.start_array(0);
  }

  void close() {
    if (!open_.back().counted) get();
    open_.back().map ? events_.end_object() : events_.end_array();
    open_.pop_back();
  }

  std::string text() {
    const int first = get();
    if (first >> 5 != 3) fail("a text is missing here");
    return textAfter(first);
  }

  std::string textAfter(int first) {
    std::string result;
    if ((first & 31) != kIndefinite) {
      append(argument(first & 31), &result);
      return result;
    }
    for (int chunk = get(); chunk != kBreak; chunk = get()) {
      if (chunk >> 5 != 3 || (chunk & 31) == kIndefinite) fail("is no CBOR: no piece of a text");
      append(argument(chunk & 31), &result);
    }
    return result;
  }

  void append(std::uint64_t count, std::string* text) {
    char block[4096];
    while (count > 0) {
      const auto wanted =
          static_cast<std::streamsize>(std::min<std::uint64_t>(count, sizeof block));
      const std::streamsize n = in_.sgetn(block, wanted);
      position_ += static_cast<std::uint64_t>(n);
      if (n < wanted) fail("the file ends inside a text", 1);
      text->append(block, static_cast<std::size_t>(n));
      count -= static_cast<std::uint64_t>(n);
    }
  }

  void simple(int info) {
    switch (info) {
      case 20:
      case 21:
        events_.boolean(info == 21);
        break;
      case 22:
        events_.null();
        break;
      case 25:
        events_.number(halfFloat(bigEndian(2)));
        break;
      case 26: {
        const auto bits = static_cast<std::uint32_t>(bigEndian(4));
        float x;
        std::memcpy(&x, &bits, sizeof x);
        events_.number(static_cast<double>(x));
        break;
      }
      case 27: {
        const std::uint64_t bits = bigEndian(8);
        double x;
        std::memcpy(&x, &bits, sizeof x);
        events_.number(x);
        break;
      }
      default:
        fail("is no value that a " + kind_ + " can have");
    }
  }

  static double halfFloat(std::uint64_t bits) {
    const int exponent = static_cast<int>(bits >> 10 & 31);
    const double mantissa = static_cast<double>(bits & 1023);
    const double size = exponent == 0    ? std::ldexp(mantissa, -24)
                        : exponent != 31 ? std::ldexp(mantissa + 1024, exponent - 25)
                        : mantissa == 0  ? HUGE_VAL
                                         : std::nan("");
    return bits & 0x8000 ? -size : size;
  }

  std::streambuf& in_;
  Events& events_;
  std::string kind_;
  std::vector<Container> open_;
  std::uint64_t position_ = 0;
};

}  // namespace octet
