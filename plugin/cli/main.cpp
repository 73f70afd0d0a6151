// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include <tbb/global_control.h>

#include <octet/core/base/error.h>
#include <octet/version.h>

#include "commands.h"
#include "console.h"

namespace {

/// What a shell reports for a program that Ctrl-C ended.
constexpr int kInterrupted = 130;
constexpr int kFailed = 1, kBadInput = 2;

int fail(const std::string& message, int code) {
  std::cerr << "octetvdb: " << message << "\n";
  return code;
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
  octet::cli::addBake(&program);
  octet::cli::addInfo(&program);
  octet::cli::addRefine(&program);
  octet::cli::watchForInterrupt();
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int code = program.exit(e);
    return code == 0 ? 0 : kBadInput;
  } catch (const octet::Cancelled&) {
    return fail("cancelled", kInterrupted);
  } catch (const octet::InputError& e) {
    return fail(e.what(), kBadInput);
  } catch (const std::bad_alloc&) {
    return fail("not enough memory", kFailed);
  } catch (const std::exception& e) {
    return fail(e.what(), kFailed);
  }
  return 0;
}
