// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <istream>
#include <streambuf>
#include <vector>

namespace octet {

/// @brief A buffer before another one that knows the line a parser has come to. Costs a look at
/// each byte when a line is asked for, nothing else.
class LineCounter : public std::streambuf {
 public:
  explicit LineCounter(std::streambuf* source) : source_(source), bytes_(kBytes) {}

  /// The line of the last byte taken but one, counted from 1: a parser takes the byte behind a
  /// number before it has the number.
  int line() {
    if (gptr() > counted_) count(gptr() - 1);
    return line_;
  }

 protected:
  int_type underflow() override {
    if (gptr() < egptr()) return traits_type::to_int_type(*gptr());
    if (counted_) count(egptr());
    const std::streamsize n = source_->sgetn(bytes_.data(), kBytes);
    setg(bytes_.data(), bytes_.data(), bytes_.data() + n);
    counted_ = eback();
    return n > 0 ? traits_type::to_int_type(*gptr()) : traits_type::eof();
  }

 private:
  static constexpr std::streamsize kBytes = 1 << 16;

  void count(const char* end) {
    line_ += static_cast<int>(std::count(counted_, end, '\n'));
    counted_ = end;
  }

  std::streambuf* source_;
  std::vector<char> bytes_;
  const char* counted_ = nullptr;  // line ends before it are in line_
  int line_ = 1;
};

}  // namespace octet
