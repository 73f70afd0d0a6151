// SPDX-License-Identifier: Apache-2.0
#include "frames.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <regex>
#include <unordered_set>

#include <octet/core/base/error.h>

namespace octet {
namespace {

namespace fs = std::filesystem;

/// Frames beyond are a slip of the pen.
constexpr std::int64_t kMostFrames = 1000000, kLargestFrame = 99999999;
constexpr int kMostDigits = 9;
constexpr int kDigitsOfWord = 4;  // of <frame>, and of the names of sequences

[[noreturn]] void refuse(const std::string& text, const std::string& reason) {
  throw InputError("frames", "\"" + text + "\" " + reason);
}

std::int64_t number(const std::string& text, const std::string& digits) {
  std::int64_t value = 0;
  const char* const last = digits.data() + digits.size();
  const auto [end, status] = std::from_chars(digits.data(), last, value);
  if (status != std::errc() || end != last || std::abs(value) > kLargestFrame) {
    refuse(text, "has a number too large for a frame");
  }
  return value;
}

/// At least so many characters, a sign among them.
std::string padded(int frame, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%0*d", digits, frame);
  return text;
}

}  // namespace

std::vector<int> parseFrames(const std::string& text) {
  static const std::regex kPart(R"((-?\d+)(?:-(-?\d+)(?:x(\d+))?)?)");
  std::vector<int> frames;
  std::unordered_set<int> seen;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, comma - begin);
    begin = comma + 1;
    std::smatch match;
    if (!std::regex_match(part, match, kPart)) {
      refuse(text, "is not a list of frames, such as 7 or 1-10 or 1-10x2 or 1,3,7-9");
    }
    const std::int64_t first = number(text, match[1]);
    const std::int64_t last = match[2].matched ? number(text, match[2]) : first;
    const std::int64_t step = match[3].matched ? number(text, match[3]) : 1;
    if (last < first) refuse(text, "is no list of frames: the first is after the last");
    if (step == 0) refuse(text, "is no list of frames: a step is 0");
    if ((last - first) / step >= kMostFrames) refuse(text, "is more than a million frames");
    for (std::int64_t frame = first; frame <= last; frame += step) {
      if (seen.insert(static_cast<int>(frame)).second) frames.push_back(static_cast<int>(frame));
    }
  }
  return frames;
}

std::string frameList(const std::vector<int>& frames) {
  std::string text;
  for (std::size_t k = 0; k < frames.size();) {
    std::size_t end = k + 1;
    const int step = end < frames.size() ? frames[end] - frames[k] : 0;
    while (step > 0 && end < frames.size() && frames[end] - frames[end - 1] == step) ++end;
    // Two frames that are not neighbours are no range.
    if (end - k == 2 && step != 1) end = k + 1;
    text += (text.empty() ? "" : ",") + std::to_string(frames[k]);
    if (end - k > 1) text += "-" + std::to_string(frames[end - 1]);
    if (end - k > 1 && step > 1) text += "x" + std::to_string(step);
    k = end;
  }
  return text;
}

FrameName::FrameName(const std::string& path) {
  static const std::regex kPlace(R"(#+|@+|%(?:0(\d))?d|\$F(\d)?|<frame>)");
  const fs::path p(path);
  folder_ = p.parent_path().string();
  const std::string name = p.filename().string();
  before_ = name;
  const auto begin = std::sregex_iterator(name.begin(), name.end(), kPlace);
  const auto end = std::sregex_iterator();
  if (begin == end) return;
  if (std::next(begin) != end) {
    throw InputError(path, "",
                     "has two places for a frame, \"" + begin->str() + "\" and \"" +
                         std::next(begin)->str() + "\"");
  }
  const std::smatch& place = *begin;
  before_ = place.prefix();
  after_ = place.suffix();
  const std::string text = place.str();
  digits_ = 1;
  if (text[0] == '#' || text[0] == '@') {
    digits_ = static_cast<int>(std::min<std::size_t>(text.size(), kMostDigits));
  }
  if (text[0] == '<') digits_ = kDigitsOfWord;
  for (const int group : {1, 2}) {
    if (place[group].matched) digits_ = std::max(1, std::stoi(place[group].str()));
  }
}

FrameName FrameName::numbered() const {
  if (hasFrame()) return *this;
  FrameName result;
  const fs::path name(before_);
  result.folder_ = folder_;
  result.before_ = name.stem().string() + ".";
  result.after_ = name.extension().string();
  result.digits_ = kDigitsOfWord;
  return result;
}

std::string FrameName::at(int frame) const {
  const std::string name = hasFrame() ? before_ + padded(frame, digits_) + after_ : before_;
  return (fs::path(folder_) / name).string();
}

std::optional<int> FrameName::frameOf(const std::string& name) const {
  if (!hasFrame() || name.size() <= before_.size() + after_.size() ||
      name.compare(0, before_.size(), before_) != 0 ||
      name.compare(name.size() - after_.size(), after_.size(), after_) != 0) {
    return std::nullopt;
  }
  const std::string digits =
      name.substr(before_.size(), name.size() - before_.size() - after_.size());
  int frame = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), frame);
  if (status != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  // Else one frame would have files "7" and "07".
  return padded(frame, digits_) == digits ? std::optional(frame) : std::nullopt;
}

std::vector<std::pair<int, std::string>> FrameName::files() const {
  std::vector<std::pair<int, std::string>> found;
  std::error_code error;
  fs::directory_iterator entries(folder_.empty() ? "." : folder_, error);
  for (; !error && entries != fs::directory_iterator(); entries.increment(error)) {
    if (const auto frame = frameOf(entries->path().filename().string())) {
      found.emplace_back(*frame, at(*frame));
    }
  }
  std::sort(found.begin(), found.end());
  if (found.empty()) {
    const std::string one = at(1);
    throw InputError("", "no file is named like " + one + ", for any frame");
  }
  return found;
}

std::string outputAt(const std::string& path, std::optional<int> frame) {
  const FrameName name(path);
  if (!name.hasFrame()) return path;
  if (!frame) {
    throw InputError("output", "\"" + path + "\" has a place for a frame, and there is none");
  }
  return name.at(*frame);
}

}  // namespace octet
