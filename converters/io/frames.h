// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

/// @file
/// Frames as farms and programs write them: lists of numbers, and names of files that hold one.

namespace octet {

/// Reads a list of frames: "7", "1-10", "1-10x2" (every second), "-5-5", and such with commas
/// between: "1,3,7-9".
/// @return each frame once, in the order of the list
/// @throws InputError (place "frames") for what is no such list, or has more than a million frames
std::vector<int> parseFrames(const std::string& text);

/// Writes frames as such a list, the other way round: 1 3 5 7 8 9 -> "1-5x2,7-9".
std::string frameList(const std::vector<int>& frames);

/// @brief The name of a file for each frame. The place of the frame is one of these, in the name
/// itself and not in its folders:
///
/// - `####`, as many digits at least as there are marks; `@@@@` likewise
/// - `%04d`, `%d`
/// - `$F4`, `$F`
/// - `<frame>`, four digits at least
///
/// A minus sign counts as a digit, as it does in `%04d`.
class FrameName {
 public:
  /// @throws InputError when the name has two such places
  explicit FrameName(const std::string& path);

  bool hasFrame() const { return digits_ > 0; }
  /// The same name with ".####" before its ending, when it has no place for a frame: a sequence.
  FrameName numbered() const;

  /// The name of a frame's file; the name itself when it has no place for a frame.
  std::string at(int frame) const;
  /// The frame whose file has this name.
  std::optional<int> frameOf(const std::string& name) const;

  /// The files that are there, by frame. @throws InputError when there are none
  std::vector<std::pair<int, std::string>> files() const;

 private:
  FrameName() = default;

  std::string folder_, before_, after_;
  int digits_ = 0;  // at least; 0: there is no place for a frame
};

/// Gives the name of the one file that a command writes: `frame` in its place.
/// @throws InputError (place "output") when a name has a place for a frame, and there is none
std::string outputAt(const std::string& path, std::optional<int> frame);

}  // namespace octet
