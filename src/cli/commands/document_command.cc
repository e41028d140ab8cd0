// tetraction document-command-line: manual pages and the completion of bash, made from the definitions
// of the command line. The build of packages calls it.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "commands.h"
#include "tetraction/core/error.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

using Commands = std::vector<const CLI::App*>;

// The commands that the help names.
Commands commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

// The options that the help names, without operands.
std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) {
    return !option->get_group().empty() && !option->get_positional();
  });
}

std::vector<const CLI::Option*> operands_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

// "tetraction mesh info", with another separator in the names of files.
std::string full_name(const CLI::App& app, const char* separator) {
  const CLI::App* parent = app.get_parent();
  return (parent != nullptr ? full_name(*parent, separator) + separator : "") + app.get_name();
}

// Text for roff: backslashes and hyphens keep their meaning, and no line is a request.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool begins_line = result.empty() || result.back() == '\n';
    if (begins_line && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
  }
  return result;
}

std::string value_of(const CLI::Option& option) {
  if (option.get_type_size() == 0) return "";
  const std::string type = option.get_type_name();
  const bool is_named = !type.empty() && type.find(' ') == std::string::npos;
  return is_named ? type.substr(0, type.find(':')) : "VALUE";
}

// -n, --count UINT
std::string spelling(const CLI::Option& option) {
  std::string text;
  for (const std::string& name : option.get_snames()) {
    text += fmt::format("{}\\fB\\-{}\\fR", text.empty() ? "" : ", ", roff(name));
  }
  for (const std::string& name : option.get_lnames()) {
    text += fmt::format("{}\\fB\\-\\-{}\\fR", text.empty() ? "" : ", ", roff(name));
  }
  const std::string value = value_of(option);
  return value.empty() ? text : fmt::format("{} \\fI{}\\fR", text, roff(value));
}

std::string manual_page(const CLI::App& app) {
  const std::string name = full_name(app, "-");
  std::string page =
      fmt::format(".TH \"{}\" 1 \"\" \"tetraction {}\" \"Tetraction\"\n.SH NAME\n{} \\- {}\n",
                  roff(name), version(), roff(name), roff(app.get_description()));
  page += fmt::format(".SH SYNOPSIS\n.B {}\n", roff(full_name(app, " ")));
  const Commands commands = commands_of(app);
  // A command may work by itself and have further commands, too.
  const bool has_own_work = commands.empty() || !operands_of(app).empty();
  if (!has_own_work) page += ".I COMMAND\n";
  for (const CLI::Option* operand : operands_of(app)) {
    const std::string word = fmt::format("\\fI{}\\fR", roff(operand->get_name()));
    page += operand->get_required() ? word + "\n" : fmt::format("[{}]\n", word);
  }
  page += "[\\fIOPTION\\fR]...\n";
  if (has_own_work && !commands.empty()) {
    page += fmt::format(".br\n.B {}\n.I COMMAND\n[\\fIOPTION\\fR]...\n", roff(full_name(app, " ")));
  }
  if (!commands.empty()) {
    page += ".SH COMMANDS\nEach of them has a manual page of its own.\n";
    for (const CLI::App* command : commands) {
      page += fmt::format(".TP\n\\fB{}\\fR(1)\n{}\n", roff(full_name(*command, "-")),
                          roff(command->get_description()));
    }
  }
  if (!operands_of(app).empty()) page += ".SH OPERANDS\n";
  for (const CLI::Option* operand : operands_of(app)) {
    page += fmt::format(".TP\n\\fI{}\\fR\n{}\n", roff(operand->get_name()),
                        roff(operand->get_description()));
  }
  page += ".SH OPTIONS\n";
  for (const CLI::Option* option : options_of(app)) {
    page += fmt::format(".TP\n{}\n{}\n", spelling(*option), roff(option->get_description()));
  }
  page +=
      ".SH EXIT STATUS\n"
      ".TP\n0\nEverything was done.\n"
      ".TP\n1\nA computation failed. The results up to there are kept.\n"
      ".TP\n2\nThe command line or the scene is wrong.\n"
      ".TP\n3\nA file cannot be read.\n"
      ".TP\n4\nResults cannot be written.\n"
      ".TP\n130, 143\nThe program was interrupted (Ctrl\\-C, SIGTERM).\n";
  if (app.get_parent() != nullptr) {
    page += fmt::format(".SH SEE ALSO\n.BR {} (1)\n", roff(full_name(*app.get_parent(), "-")));
  }
  return page;
}

void write_manual_pages(const CLI::App& app, const std::string& folder) {
  write_text_file(folder + "/" + full_name(app, "-") + ".1", manual_page(app));
  for (const CLI::App* command : commands_of(app)) write_manual_pages(*command, folder);
}

std::string words_of_commands(const CLI::App& app) {
  std::string words;
  for (const CLI::App* command : commands_of(app)) {
    words += (words.empty() ? "" : " ") + command->get_name();
  }
  return words;
}

// One branch for each command that follows another one, and one for the words that each of them takes.
void add_branches(const CLI::App& app, std::string& steps, std::string& words) {
  const std::string name = full_name(app, " ");
  std::string options;
  for (const CLI::Option* option : options_of(app)) {
    for (const std::string& own : option->get_lnames()) options += fmt::format(" --{}", own);
    for (const std::string& own : option->get_snames()) options += fmt::format(" -{}", own);
  }
  // Files are operands of the commands that have operands.
  words += fmt::format("    \"{}\") commands=\"{}\" options=\"{}\" files={} ;;\n", name,
                       words_of_commands(app), options.empty() ? "" : options.substr(1),
                       operands_of(app).empty() && !commands_of(app).empty() ? "" : "-f");
  for (const CLI::App* command : commands_of(app)) {
    steps += fmt::format("      \"{} {}\") command=\"{}\" ;;\n", name, command->get_name(),
                         full_name(*command, " "));
    add_branches(*command, steps, words);
  }
}

std::string completion_of_bash(const CLI::App& app) {
  std::string steps;
  std::string words;
  add_branches(app, steps, words);
  return fmt::format(
      "# Completion of the command line of tetraction for bash.\n"
      "_tetraction() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} command=tetraction commands options files word\n"
      "  for word in \"${{COMP_WORDS[@]:1:COMP_CWORD-1}}\"; do\n"
      "    case \"$command $word\" in\n{}    esac\n"
      "  done\n"
      "  case $command in\n{}  esac\n"
      "  if [[ $current == -* ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$options\" -- \"$current\")\n"
      "  else\n"
      "    mapfile -t COMPREPLY < <(compgen $files -W \"$commands\" -- \"$current\")\n"
      "  fi\n"
      "}}\n"
      "complete -o filenames -F _tetraction tetraction\n",
      steps, words);
}

}  // namespace

void add_document_command(CLI::App& app, int& exit_code) {
  CLI::App* command =
      app.add_subcommand("document-command-line", "Write manual pages, or the completion of bash");
  command->group("");  // not in the help
  struct Arguments {
    std::string kind;
    std::string path;
  };
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("kind", arguments->kind, "man or bash")
      ->required()
      ->check(CLI::IsMember({"man", "bash"}));
  command
      ->add_option("path", arguments->path, "Folder of the manual pages, or file of the completion")
      ->required()
      ->check(not_empty("it names no path"));
  command->callback([arguments, &app, &exit_code] {
    if (arguments->kind == "man") {
      write_manual_pages(app, arguments->path);
    } else {
      write_text_file(arguments->path, completion_of_bash(app));
    }
    exit_code = 0;
  });
}

}  // namespace tetraction
