// SPDX-License-Identifier: Apache-2.0
#include "reference.h"

#include <functional>
#include <iostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <octet/version.h>

#include "failure.h"

namespace octet::cli {
namespace {

using Rows = std::vector<std::pair<std::string, std::string>>;

Rows exitCodes() {
  const auto code = [](ExitCode c) { return std::to_string(c); };
  return {{code(kDone), "done"},
          {code(kFailed), "failed: a file cannot be written, a limit of verify is passed"},
          {code(kBadInput), "options, an asset or a file cannot be used: once more will not help"},
          {code(kNoMemory), "needs more memory than there is: OpenCue retries it with more"},
          {std::to_string(kSignal + 2) + ", " + std::to_string(kSignal + 15),
           "ended by SIGINT, SIGTERM; nothing half written is left"}};
}

Rows environment() {
  return {{"SLURM_CPUS_PER_TASK, CUE_THREADS", "threads, unless --threads is given"},
          {"SLURM_MEM_PER_NODE, CUE_MEMORY",
           "memory that may be used, in MB and KB; with the machine's and its control groups' the "
           "least counts"}};
}

Rows frameNames() {
  return {{"name.####.vdb, name.@@@@.vdb", "as many digits at least as there are marks"},
          {"name.%04d.vdb, name.$F4.vdb", "four digits at least; %d and $F: one"},
          {"name.<frame>.vdb", "four digits at least"},
          {"name.vdb", "name.0001.vdb and so on, of an animated asset"}};
}

/// One option, as all three forms need it.
struct Described {
  std::string names, value, help;
  std::vector<std::string> words, choices;
  bool positional = false, required = false;
};

/// "a|b|c" as a list; empty for other texts.
std::vector<std::string> choicesIn(const std::string& text) {
  if (text.find('|') == text.npos || text.find_first_of("[ ") != text.npos) return {};
  return CLI::detail::split(text, '|');
}

std::vector<Described> optionsOf(const CLI::App& app) {
  std::vector<Described> result;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    Described d;
    d.positional = !option->nonpositional();
    d.required = option->get_required();
    for (const std::string& name : option->get_snames()) d.words.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) d.words.push_back("--" + name);
    d.names = d.positional ? option->get_name() : CLI::detail::join(d.words, ", ");
    d.choices = choicesIn(option->get_option_text());
    if (!option->get_option_text().empty()) {
      d.value = option->get_option_text();
    } else if (!d.positional && option->get_items_expected_max() > 0) {
      d.value = option->get_type_name();
      d.value = d.value.substr(0, d.value.find(':'));
    }
    d.help = option->get_description();
    const std::string byDefault = option->get_default_str();
    if (!byDefault.empty()) d.help += " (default: " + byDefault + ")";
    if (d.required && !d.positional) d.help += " (required)";
    result.push_back(std::move(d));
  }
  return result;
}

std::vector<const CLI::App*> commandsOf(const CLI::App& program) {
  std::vector<const CLI::App*> commands;
  for (const CLI::App* command : program.get_subcommands({})) commands.push_back(command);
  return commands;
}

/// "bake CONTROL -o FILE [OPTIONS]", for short.
std::string synopsis(const CLI::App& command) {
  std::string text = "octetvdb " + command.get_name();
  for (const Described& d : optionsOf(command)) {
    if (d.positional) text += d.required ? " " + d.names : " [" + d.names + "]";
  }
  for (const Described& d : optionsOf(command)) {
    if (!d.positional && d.required) text += " " + d.words.back() + " " + d.value;
  }
  return text + " [OPTIONS]";
}

// ---- man ----------------------------------------------------------------------------------------

std::string troff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '-' || c == '\\') result += '\\';
    if (result.empty() && (c == '.' || c == '\'')) result += "\\&";
    result += c == '\\' ? 'e' : c;
  }
  return result;
}

void manRows(std::ostream& out, const char* heading, const Rows& rows) {
  out << ".SH " << heading << "\n";
  for (const auto& [name, help] : rows) {
    out << ".TP\n.B " << troff(name) << "\n" << troff(help) << "\n";
  }
}

void manOptions(std::ostream& out, const CLI::App& app) {
  for (const Described& d : optionsOf(app)) {
    out << ".TP\n.B " << troff(d.names);
    if (!d.value.empty()) out << " \\fI" << troff(d.value) << "\\fR";
    out << "\n" << troff(d.help) << "\n";
  }
}

void printMan(const CLI::App& program, std::ostream& out) {
  out << ".TH OCTETVDB 1 \"\" \"OctetVDB " << kVersion << "\" \"User Commands\"\n"
      << ".SH NAME\noctetvdb \\- "
      << "exactly incompressible velocity fields, baked to OpenVDB\n"
      << ".SH SYNOPSIS\n";
  for (const CLI::App* command : commandsOf(program)) {
    out << ".B " << troff(synopsis(*command)) << "\n.br\n";
  }
  out << ".SH DESCRIPTION\n" << troff(program.get_description()) << "\n.SH OPTIONS\n";
  manOptions(out, program);
  out << ".SH COMMANDS\n";
  for (const CLI::App* command : commandsOf(program)) {
    out << ".SS " << troff(command->get_name()) << "\n"
        << troff(command->get_description()) << "\n";
    manOptions(out, *command);
  }
  manRows(out, "NAMES OF FRAMES", frameNames());
  manRows(out, "ENVIRONMENT", environment());
  manRows(out, "EXIT STATUS", exitCodes());
}

// ---- Markdown -----------------------------------------------------------------------------------

std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? "\\|" : std::string(1, c);
  return result;
}

void markdownRows(std::ostream& out, const std::string& head, const Rows& rows) {
  out << "| " << head << " |\n|---|---|\n";
  for (const auto& [name, help] : rows) out << "| `" << name << "` | " << cell(help) << " |\n";
  out << "\n";
}

void markdownOptions(std::ostream& out, const CLI::App& app) {
  Rows rows;
  for (const Described& d : optionsOf(app)) {
    if (d.names == "-h, --help") continue;
    rows.emplace_back(d.names + (d.value.empty() ? "" : " " + cell(d.value)), d.help);
  }
  markdownRows(out, "option | means", rows);
}

void printMarkdown(const CLI::App& program, std::ostream& out) {
  out << "## Names of frames\n\n";
  markdownRows(out, "name of a file | becomes", frameNames());
  out << "## Exit codes\n\n";
  markdownRows(out, "code | means", exitCodes());
  out << "## Environment\n\n";
  markdownRows(out, "variable | says", environment());
  out << "## Every command\n\n";
  markdownOptions(out, program);
  for (const CLI::App* command : commandsOf(program)) {
    out << "## " << command->get_name() << "\n\n"
        << command->get_description() << ".\n\n    " << synopsis(*command) << "\n\n";
    markdownOptions(out, *command);
  }
}

// ---- bash ---------------------------------------------------------------------------------------

std::string wordsOf(const CLI::App& app) {
  std::string words;
  for (const Described& d : optionsOf(app)) {
    for (const std::string& word : d.words) words += (words.empty() ? "" : " ") + word;
  }
  return words;
}

/// A line of a `case`: words for what stands after an option with choices.
void bashChoices(std::ostream& out, const std::string& command, const CLI::App& app) {
  for (const Described& d : optionsOf(app)) {
    if (d.choices.empty()) continue;
    out << "    \"" << command << " " << d.words.back() << "\") words=\""
        << CLI::detail::join(d.choices, " ") << "\" ;;\n";
  }
}

void printBash(const CLI::App& program, std::ostream& out) {
  std::string names;
  for (const CLI::App* command : commandsOf(program)) {
    names += (names.empty() ? "" : " ") + command->get_name();
  }
  std::string cases = names;
  for (char& c : cases) c = c == ' ' ? '|' : c;
  out << "# bash completion of octetvdb " << kVersion << "\n"
      << "_octetvdb() {\n"
      << "  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]}\n"
      << "  local command= word words=\n"
      << "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
      << "    case $word in " << cases << ") command=$word; break ;; esac\n  done\n"
      << "  COMPREPLY=()\n"
      << "  case \"$command $prev\" in\n";
  for (const CLI::App* command : commandsOf(program)) {
    bashChoices(out, command->get_name(), *command);
    bashChoices(out, command->get_name(), program);
  }
  bashChoices(out, "", program);
  out << "    *)\n      [[ $cur == -* || -z $command ]] || return  # a file's name\n"
      << "      case $command in\n";
  for (const CLI::App* command : commandsOf(program)) {
    out << "        " << command->get_name() << ") words=\"" << wordsOf(*command) << " "
        << wordsOf(program) << "\" ;;\n";
  }
  out << "        *) words=\"" << names << " " << wordsOf(program)
      << "\" ;;\n      esac ;;\n  esac\n"
      << "  COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n}\n"
      << "complete -o default -F _octetvdb octetvdb\n";
}

}  // namespace

void addReference(CLI::App* program) {
  const auto print = [program](const std::string& kind) {
    if (kind == "man") printMan(*program, std::cout);
    if (kind == "markdown") printMarkdown(*program, std::cout);
    if (kind == "bash") printBash(*program, std::cout);
    throw CLI::Success();
  };
  program->add_option_function<std::string>("--reference", print)
      ->check(CLI::IsMember({"man", "markdown", "bash"}))
      ->group("");
}

}  // namespace octet::cli
