// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <tbb/global_control.h>

#include <octet/version.h>

#include "commands.h"
#include "console.h"
#include "failure.h"
#include "progress.h"
#include "reference.h"
#include "versions.h"

namespace octet::cli {
namespace {

constexpr int kMostThreads = 1024;

/// Limits oneTBB to some threads. The least of several limits would hold: there is one.
class Threads {
 public:
  void limit(int count) {
    control_.reset();
    control_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                     static_cast<std::size_t>(count));
  }
  /// What a farm has given this process: Slurm's processors of a task, OpenCue's threads.
  void limitByFarm() {
    for (const char* const name : {"SLURM_CPUS_PER_TASK", "CUE_THREADS"}) {
      const char* const text = std::getenv(name);
      const int count = text ? std::atoi(text) : 0;
      if (count >= 1 && count <= kMostThreads) return limit(count);
    }
  }

 private:
  std::unique_ptr<tbb::global_control> control_;
};

void addCommands(CLI::App* program) {
  addAdd(program);
  addAnalyse(program);
  addBake(program);
  addFill(program);
  addFit(program);
  addInfo(program);
  addMerge(program);
#ifdef OCTETVDB_WITH_PICTURES
  addPreview(program);
#endif
  addRefine(program);
  addSample(program);
  addVerify(program);
}

/// Options of every command.
void addCommon(CLI::App* program, Threads* threads) {
  program->fallthrough();
  program
      ->add_option_function<int>(
          "--threads", [threads](int n) { threads->limit(n); },
          "Number of threads; by default SLURM_CPUS_PER_TASK or CUE_THREADS, else all processors")
      ->check(CLI::Range(1, kMostThreads))
      ->trigger_on_parse();
  std::string names;
  for (const auto& [name, value] : progressStyles()) names += (names.empty() ? "" : "|") + name;
  program
      ->add_option_function<std::string>(
          "--progress",
          [](const std::string& name) {
            const auto& styles = progressStyles();
            for (const auto& [known, style] : styles) {
              if (CLI::detail::to_lower(name) == known) return setProgress(style);
            }
            throw CLI::ValidationError("--progress", "\"" + name + "\" is none of " +
                                                         listOf(namesOf(styles)) +
                                                         didYouMean(name, namesOf(styles)));
          },
          "How progress is told, on stderr; auto: a bar on a terminal, else a line each 10 % or 10 "
          "s")
      ->option_text(names)
      ->trigger_on_parse();
}

std::vector<std::string> commandNames(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> optionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// Of mistakes in the use of the command.
Failure usageFailure(const CLI::App& program, const CLI::ParseError& e) {
  std::string command = "octetvdb", message = e.what();
  std::vector<std::string> options = optionNames(program);
  const CLI::App* chosen = &program;
  for (const CLI::App* sub : program.get_subcommands()) {
    chosen = sub;
    command += " " + sub->get_name();
    for (const std::string& name : optionNames(*sub)) options.push_back(name);
  }
  const std::vector<std::string> rest = program.remaining(true);
  if (chosen == &program && !rest.empty() && rest.front()[0] != '-') {
    message = "there is no command \"" + rest.front() + "\"" +
              didYouMean(rest.front(), commandNames(program));
  } else if (!rest.empty() && rest.front()[0] == '-') {
    const std::string option = rest.front().substr(0, rest.front().find('='));
    message = "there is no option " + option + didYouMean(option, options);
  }
  const bool question = !message.empty() && message.back() == '?';
  Failure failure{
      kBadInput, "usage", message + (question ? " See " : "; see ") + command + " --help",
      "",        "",      message,
      0,         0};
  return failure;
}

/// Is JSON asked for? Known before the options are, for mistakes in them.
bool wantsJson(int argc, char** argv) {
  for (int k = 1; k < argc && std::strcmp(argv[k], "--") != 0; ++k) {
    if (std::strcmp(argv[k], "--json") == 0) return true;
  }
  return false;
}

int run(CLI::App* program, int argc, char** argv) {
  const bool json = wantsJson(argc, argv);
  try {
    program->parse(argc, argv);
  } catch (const CLI::CallForVersion&) {
    std::cout << (json ? text(versions()) : std::string(kVersion)) << "\n";
  } catch (const CLI::Success& e) {
    program->exit(e);
  } catch (const CLI::ParseError& e) {
    return tell(usageFailure(*program, e), json);
  } catch (const AlreadyTold& e) {
    return e.code;
  } catch (const std::exception& e) {
    return tell(failureOf(e), json);
  }
  finishProgress();
  if (!std::cout.flush() || std::fflush(stdout) != 0) {
    return tell({kFailed, "io", "the summary could not be written to standard output", "", "",
                 "the summary could not be written to standard output", 0, 0},
                false);
  }
  return kDone;
}

}  // namespace
}  // namespace octet::cli

int main(int argc, char** argv) {
  using namespace octet::cli;
  CLI::App program{
      "Smooth, exactly incompressible or curl-free velocity fields, from a coarse cage to OpenVDB.",
      "octetvdb"};
  program.set_version_flag("--version", octet::kVersion,
                           "Print the version; with --json libraries, threads and memory, too");
  program.require_subcommand(1);
  Threads threads;
  threads.limitByFarm();
  addCommon(&program, &threads);
  addCommands(&program);
  addReference(&program);
  for (CLI::App* command : program.get_subcommands({})) {
    command->footer("With every command: --threads N, and --progress STYLE; see octetvdb --help");
  }
  watchForInterrupt();
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the limit is then an error like a full disk
  return run(&program, argc, argv);
}
