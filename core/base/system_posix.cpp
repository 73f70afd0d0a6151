// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "system.h"
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include "error.h"

extern char** environ;

namespace octet::system {
namespace {

namespace fs = std::filesystem;

std::error_code lastError() { return {errno, std::generic_category()}; }

[[noreturn]] void fail(const std::string& name, const char* what, int error) {
  throw IoError(name, std::string(what) + ": " + std::strerror(error));
}

void limitResource(int resource, rlim_t value) {
  rlimit limit;
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min(value, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

/// An open file; closed at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  int release() { return std::exchange(number_, -1); }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }
  /// Takes a file, out of the way of the standard ones, which children get in their place.
  void take(int number) {
    number_ = number;
    if (number < 0 || number > STDERR_FILENO) return;
    number_ = ::fcntl(number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    ::close(number);
  }

 private:
  int number_;
};

/// The standard files of a child and our ends of them.
struct Pipes {
  Descriptor childInput, input, output, childOutput;

  Pipes() {
    int ends[2];
    // A socket: writing to one that nobody reads can be an error instead of a signal.
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) give("a socket");
    childInput.take(ends[0]);
    input.take(ends[1]);
    if (::pipe2(ends, O_CLOEXEC) != 0) give("a pipe");
    output.take(ends[0]);
    childOutput.take(ends[1]);
    for (const Descriptor* d : {&childInput, &input, &output, &childOutput}) {
      if (d->number() < 0) give("a pipe");
    }
    ::fcntl(output.number(), F_SETFL, O_NONBLOCK);
  }

 private:
  [[noreturn]] static void give(const char* what) {
    fail("", (std::string("cannot make ") + what).c_str(), errno);
  }
};

/// How a child starts: its standard files, and signals as in a program started by hand.
class SpawnSettings {
 public:
  explicit SpawnSettings(const Pipes& pipes) {
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_adddup2(&files, pipes.childInput.number(), STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, pipes.childOutput.number(), STDOUT_FILENO);
    ::posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 34)
    ::posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
#endif
    ::posix_spawnattr_init(&attributes);
    sigset_t none, all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setsigdefault(&attributes, &all);
    ::posix_spawnattr_setpgroup(&attributes, 0);
    ::posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnSettings() {
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
};

}  // namespace

// ---- memory -------------------------------------------------------------------------------------

std::uint64_t physicalMemory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || size <= 0) return 0;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(size);
}

void preferHugePages(void* block, std::size_t bytes) {
#ifdef __linux__
  ::madvise(block, bytes, MADV_HUGEPAGE);
#else
  (void)block, (void)bytes;
#endif
}

// ---- files --------------------------------------------------------------------------------------

int processNumber() { return static_cast<int>(::getpid()); }

std::error_code createNewFile(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666));
  return file.number() < 0 ? lastError() : std::error_code();
}

std::error_code flushToDisk(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  return file.number() < 0 || ::fsync(file.number()) != 0 ? lastError() : std::error_code();
}

std::error_code replaceFile(const std::string& from, const std::string& to) {
  return ::rename(from.c_str(), to.c_str()) != 0 ? lastError() : std::error_code();
}

std::string makeTemporaryFolder(const std::string& prefix) {
  std::string folder = fs::temp_directory_path() / (prefix + "XXXXXX");
  if (!::mkdtemp(folder.data())) fail(folder, "cannot be made", errno);
  return folder;
}

// ---- code ---------------------------------------------------------------------------------------

std::string fileOfThisCode() {
  Dl_info info;
  const bool found = ::dladdr(reinterpret_cast<const void*>(&fileOfThisCode), &info) != 0;
  // A library's name is whole; that of the program is what it was called by.
  const bool library = found && info.dli_fname && info.dli_fname[0] == '/';
  std::error_code error;
  const fs::path file = fs::canonical(library ? info.dli_fname : "/proc/self/exe", error);
  return error ? std::string() : file.string();
}

bool isExecutable(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) && ::access(path.c_str(), X_OK) == 0;
}

std::string findOnPath(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::string_view rest = path ? path : "";
  while (!rest.empty()) {
    const std::string_view folder = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(rest.size(), folder.size() + 1));
    if (folder.empty() || folder.front() != '/') continue;
    const std::string file = fs::path(folder) / name;
    if (isExecutable(file)) return file;
  }
  return "";
}

void* loadLibrary(const std::string& name) {
  return ::dlopen(name.c_str(), RTLD_LAZY | RTLD_LOCAL);
}

std::string loadError() {
  const char* const error = ::dlerror();
  return error ? error : "";
}

void* functionOf(void* library, const char* name) { return ::dlsym(library, name); }

// ---- child processes ----------------------------------------------------------------------------

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  Pipes pipes;
  const SpawnSettings settings(pipes);
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = -1;
  const int error = ::posix_spawn(&child, arguments[0], &settings.files, &settings.attributes,
                                  arguments.data(), environ);
  if (error != 0) fail(command.at(0), "cannot be started", error);
  process_ = child;
  input_ = pipes.input.release();
  output_ = pipes.output.release();
}

ChildProcess::~ChildProcess() {
  end();
  closeInput();
  if (output_ >= 0) ::close(output_);
}

ChildProcess::Moved ChildProcess::exchange(std::string_view input, char* output, std::size_t room,
                                           std::chrono::milliseconds most) {
  pollfd files[] = {{output_, POLLIN, 0}, {input.empty() ? -1 : input_, POLLOUT, 0}};
  Moved moved;
  const auto wait = std::min<long long>(most.count(), 1 << 30);
  if (::poll(files, 2, static_cast<int>(std::max<long long>(wait, 0))) <= 0) return moved;
  if (files[1].revents) {
    const ssize_t n = ::send(input_, input.data(), input.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n > 0) moved.written = static_cast<std::size_t>(n);
    moved.refused = n < 0 && errno != EAGAIN && errno != EINTR;
  }
  if (files[0].revents) {
    const ssize_t n = ::read(output_, output, room);
    if (n > 0) moved.read = static_cast<std::size_t>(n);
    moved.closed = n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR);
  }
  return moved;
}

void ChildProcess::closeInput() {
  if (input_ >= 0) ::close(input_);
  input_ = -1;
}

std::string ChildProcess::wait(std::chrono::milliseconds most) {
  const auto deadline = std::chrono::steady_clock::now() + most;
  int status = 0;
  pid_t ended = 0;
  while ((ended = ::waitpid(process_, &status, WNOHANG)) == 0 &&
         std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (ended == 0) {
    end();
    return "did not end";
  }
  process_ = -1;
  if (ended < 0) return "";  // a host that reaps children for itself leaves us no status
  if (WIFSIGNALED(status)) return "crashed (signal " + std::to_string(WTERMSIG(status)) + ")";
  if (WEXITSTATUS(status) == 0) return "";
  return "ended early (exit status " + std::to_string(WEXITSTATUS(status)) + ")";
}

void ChildProcess::end() {
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
}

void becomeChild() {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  limitResource(RLIMIT_CORE, 0);
}

void limitMemory(std::uint64_t bytes) {
  std::uint64_t pages = 0;
  if (!(std::ifstream("/proc/self/statm") >> pages)) return;
  limitResource(RLIMIT_AS, pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + bytes);
}

std::FILE* takeStandardOutput() {
  Descriptor own(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
  const Descriptor null(::open("/dev/null", O_WRONLY | O_CLOEXEC));
  std::FILE* const file = own.number() < 0 ? nullptr : ::fdopen(own.number(), "wb");
  if (!file || null.number() < 0 || ::dup2(null.number(), STDOUT_FILENO) < 0) {
    fail("standard output", "cannot be taken", errno);
  }
  own.release();
  return file;
}

}  // namespace octet::system
