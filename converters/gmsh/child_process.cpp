// SPDX-License-Identifier: Apache-2.0
#include "child_process.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <fstream>

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <octet/core/base/error.h>

namespace octet::gmsh_import {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kExitException = 3;

void limitResource(int resource, rlim_t value) {
  rlimit limit;
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min(value, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

/// Address space in use, 0 where the system does not tell.
std::uint64_t addressSpace() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Makes the child end quietly and not outlive its parent.
void settleInChild(const ChildLimits& limits) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  // Crash handlers of the host (Blender, Python's faulthandler) would report the child's crash as
  // theirs. Ctrl-C is for the parent to act on.
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTERM, SIGPIPE}) {
    std::signal(signal, SIG_DFL);
  }
  std::signal(SIGINT, SIG_IGN);
  limitResource(RLIMIT_CORE, 0);
  if (const std::uint64_t used = addressSpace()) limitResource(RLIMIT_AS, used + limits.memory);
  const int null = ::open("/dev/null", O_RDWR);
  for (int fd = 0; fd < 3; ++fd) ::dup2(null, fd);
}

bool writeAll(int fd, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = ::write(fd, data, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    data += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

[[noreturn]] void childMain(int out, const std::function<std::string()>& work,
                            const ChildLimits& limits) {
  int status = kExitException;
  out = ::fcntl(out, F_DUPFD, 3);  // out of the way of /dev/null
  settleInChild(limits);
  try {
    const std::string bytes = work();
    const std::uint64_t size = bytes.size();
    if (writeAll(out, reinterpret_cast<const char*>(&size), sizeof size) &&
        writeAll(out, bytes.data(), bytes.size())) {
      status = 0;
    }
  } catch (...) {
  }
  ::_exit(status);  // no destructors, no exit handlers, no flushing of the parent's buffers
}

enum class End { Closed, Late, Stopped };

/// Reads until the other end closes, the deadline passes or `goOn` says no.
End readAll(int in, Clock::time_point deadline, const std::function<bool()>& goOn,
            std::string* bytes) {
  constexpr long long kAskEvery = 100;  // ms
  std::string buffer(1 << 16, '\0');
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return End::Late;
    if (goOn && !goOn()) return End::Stopped;
    pollfd wait = {in, POLLIN, 0};
    const long long most = goOn ? kAskEvery : 1 << 30;
    if (::poll(&wait, 1, static_cast<int>(std::min<long long>(left, most))) <= 0) continue;
    const ssize_t n = ::read(in, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return End::Closed;
    bytes->append(buffer, 0, static_cast<std::size_t>(n));
  }
}

/// Takes the size off the front; false when the message is not whole.
bool unwrap(std::string* message) {
  std::uint64_t size = 0;
  if (message->size() < sizeof size) return false;
  std::memcpy(&size, message->data(), sizeof size);
  message->erase(0, sizeof size);
  return message->size() == size;
}

std::string describe(int status) {
  if (WIFSIGNALED(status)) return "crashed (signal " + std::to_string(WTERMSIG(status)) + ")";
  return "ended early (exit status " + std::to_string(WEXITSTATUS(status)) + ")";
}

}  // namespace

ChildResult runInChild(const std::function<std::string()>& work, const ChildLimits& limits) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    throw IoError("", std::string("cannot make a pipe: ") + std::strerror(errno));
  }
  const pid_t child = ::fork();
  if (child == 0) childMain(ends[1], work, limits);
  const int error = errno;
  ::close(ends[1]);
  if (child < 0) {
    ::close(ends[0]);
    throw IoError("", std::string("cannot start a process: ") + std::strerror(error));
  }
  ChildResult result;
  End end = End::Stopped;
  std::exception_ptr thrown;  // by goOn; the child must not be left behind
  try {
    end = readAll(ends[0], Clock::now() + limits.time, limits.goOn, &result.bytes);
  } catch (...) {
    thrown = std::current_exception();
  }
  ::close(ends[0]);
  if (end != End::Closed) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (thrown) std::rethrow_exception(thrown);
  // The message itself tells whether all went well: a host that reaps children for itself leaves us
  // no status.
  if (end == End::Stopped) {
    result.stopped = true;
    result.failure = "was stopped";
  } else if (end == End::Late) {
    result.failure =
        "did not finish within " + std::to_string(limits.time.count() / 1000) + " seconds";
  } else if (!unwrap(&result.bytes)) {
    result.failure = describe(status);
  }
  return result;
}

}  // namespace octet::gmsh_import
