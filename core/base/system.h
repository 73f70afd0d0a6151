// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

/// @file
/// What is asked of the operating system beyond the standard library. One file answers for each
/// system (system_posix.cpp); no other file of the core and the converters includes its headers.

namespace octet::system {

// ---- memory -------------------------------------------------------------------------------------

/// Returns the machine's memory in bytes, 0 where the system does not tell.
std::uint64_t physicalMemory();

/// Asks that a block, aligned to its pages, lies on huge pages, where the system has them.
void preferHugePages(void* block, std::size_t bytes);

// ---- files --------------------------------------------------------------------------------------

/// Returns the number that no other process of this machine has now.
int processNumber();

/// Makes an empty file; an existing one is an error (std::errc::file_exists).
std::error_code createNewFile(const std::string& path);

/// Waits until what was written to a file is on the disk.
std::error_code flushToDisk(const std::string& path);

/// Gives a file another name, at once: whoever opens that name gets the old or the new file, whole.
std::error_code replaceFile(const std::string& from, const std::string& to);

/// Makes a folder that only this user may enter, in the one for temporary files.
/// @throws IoError
std::string makeTemporaryFolder(const std::string& prefix);

// ---- code ---------------------------------------------------------------------------------------

/// Returns the file, program or library, that holds this function, and the running code with it;
/// empty where the system does not tell.
std::string fileOfThisCode();

/// Returns the first executable file of that name in the folders of PATH, else an empty name.
/// Folders that are relative to the current one are passed over.
std::string findOnPath(const std::string& name);

bool isExecutable(const std::string& path);

/// Loads a library for as long as the process lives; null when that fails, and then `loadError`
/// tells why.
void* loadLibrary(const std::string& name);
std::string loadError();
/// Returns the address of a library's function, null when it has none of that name.
void* functionOf(void* library, const char* name);

// ---- child processes ----------------------------------------------------------------------------

/// @brief A program that runs beside this one, with a pipe to its standard input, another from its
/// standard output, and its messages (standard error) dropped.
///
/// It gets this process' environment and none of its open files or signal handlers; what interrupts
/// this process at its terminal does not reach it. The destructor ends it: it is never left behind.
class ChildProcess {
 public:
  /// Starts the file command[0] with the arguments after it.
  /// @throws IoError when that fails
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// What an exchange moved.
  struct Moved {
    std::size_t written = 0, read = 0;
    bool refused = false;  ///< the child has closed its input
    bool closed = false;   ///< the child has closed its output: all of it has been read
  };
  /// Waits until the child takes some of `input` (if there is any) or has written something, for
  /// `most` at most, then moves what there is without waiting.
  Moved exchange(std::string_view input, char* output, std::size_t room,
                 std::chrono::milliseconds most);

  /// Lets the child see the end of its input.
  void closeInput();

  /// Waits for the child's end, and ends it when `most` is over.
  /// @return how it ended unless well: "crashed (signal 11)", "ended early (exit status 3)"
  std::string wait(std::chrono::milliseconds most);

 private:
  void end();

  int process_ = -1, input_ = -1, output_ = -1;
};

/// Is called by a program first that a ChildProcess runs: it then ends when its parent does, and
/// leaves no memory dumps.
void becomeChild();

/// Limits this process' address space to what it takes now and `bytes` more.
void limitMemory(std::uint64_t bytes);

/// Returns the standard output as a file for this caller alone: what others print is dropped.
/// @throws IoError
std::FILE* takeStandardOutput();

}  // namespace octet::system
