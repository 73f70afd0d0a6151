// SPDX-License-Identifier: Apache-2.0
#include "text_lines.h"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>

#include <octet/core/base/error.h>

namespace octet {

void visitLines(const std::string& path, const std::function<void(std::string_view, int)>& visit) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  std::string line;
  int number = 0;
  while (std::getline(file, line)) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    std::string_view text = line;
    if (number == 1 && text.substr(0, 3) == kByteOrderMark) text.remove_prefix(3);
    visit(text, number);
  }
  if (file.bad()) throw InputError(path, "", "cannot be read to its end");
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::vector<std::string_view> splitText(std::string_view text, std::string_view separators) {
  const bool blanks = separators == " \t";
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find_first_of(separators);
    const std::string_view part = trimmed(text.substr(0, end));
    if (!blanks || !part.empty()) parts.push_back(part);
    if (end == text.npos) return parts;
    text.remove_prefix(end + 1);
  }
}

double parseNumber(std::string_view text, const std::string& file, const std::string& place) {
  double value = 0;
  const char* const last = text.data() + text.size();
  const char* const first = text.data() + (text.size() > 1 && text.front() == '+' ? 1 : 0);
  const auto [end, status] = std::from_chars(first, last, value);
  if (status != std::errc() || end != last) {
    throw InputError(file, place, "\"" + std::string(text) + "\" is not a number");
  }
  return value;
}

}  // namespace octet
