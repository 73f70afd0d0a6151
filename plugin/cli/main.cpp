// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <iostream>
#include <memory>

#include <tbb/global_control.h>

#include <octet/core/base/memory_budget.h>
#include <octet/version.h>

#include "commands.h"
#include "console.h"

namespace {

/// What a shell reports for a program that a signal ended, less the signal's number.
constexpr int kInterrupted = 128;
constexpr int kFailed = 1, kBadInput = 2;
/// Longest message; names in a malformed file can be of any length.
constexpr std::size_t kLongestMessage = 4000;

/// One line on stderr, whatever the names in the message hold.
int fail(std::string message, int code) {
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
  }
  if (message.size() > kLongestMessage) message = message.substr(0, kLongestMessage) + "...";
  octet::cli::clearProgress();
  std::cerr << "octetvdb: " << message << "\n";
  return code;
}

int failUsage(const CLI::App& program, const CLI::ParseError& e) {
  std::string command = "octetvdb", message = e.what();
  for (const CLI::App* chosen : program.get_subcommands()) command += " " + chosen->get_name();
  if (program.get_subcommands().empty() && program.remaining_size() > 0) {
    message = "there is no command \"" + program.remaining().front() + "\"";
  }
  return fail(message + "; see " + command + " --help", kBadInput);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{
      "Smooth, exactly incompressible or curl-free velocity fields, from a coarse cage "
      "to OpenVDB.",
      "octetvdb"};
  program.set_version_flag("--version", octet::kVersion);
  program.require_subcommand(1);
  program.fallthrough();
  std::unique_ptr<tbb::global_control> threads;
  program
      .add_option_function<int>(
          "--threads",
          [&](int n) {
            threads = std::make_unique<tbb::global_control>(
                tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(n));
          },
          "Number of threads; all by default")
      ->check(CLI::Range(1, 1024))
      ->trigger_on_parse();
  octet::cli::addAdd(&program);
  octet::cli::addAnalyse(&program);
  octet::cli::addBake(&program);
  octet::cli::addFill(&program);
  octet::cli::addFit(&program);
  octet::cli::addInfo(&program);
  octet::cli::addMerge(&program);
#ifdef OCTETVDB_WITH_PICTURES
  octet::cli::addPreview(&program);
#endif
  octet::cli::addRefine(&program);
  octet::cli::addSample(&program);
  octet::cli::addVerify(&program);
  for (CLI::App* command : program.get_subcommands({})) {
    command->footer("With every command: --threads N, the number of threads; all by default");
  }
  octet::cli::watchForInterrupt();
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the limit is then an error like a full disk
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& e) {
    program.exit(e);
  } catch (const CLI::ParseError& e) {
    return failUsage(program, e);
  } catch (const octet::Cancelled&) {
    return fail("cancelled", kInterrupted + octet::cli::interruptSignal());
  } catch (const octet::InputError& e) {
    return fail(e.what(), kBadInput);
  } catch (const octet::MemoryError& e) {
    return fail(e.what(), kBadInput);
  } catch (const std::bad_alloc&) {
    return fail("not enough memory", kFailed);
  } catch (const std::exception& e) {
    return fail(e.what(), kFailed);
  }
  if (!std::cout.flush() || std::fflush(stdout) != 0) {
    return fail("the summary could not be written to standard output", kFailed);
  }
  return 0;
}
