#include "services/platform/command_line/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "services/platform/command_line/option_text.h"

namespace intaglio::command_line {
namespace {

using Visit = std::function<void(const CommandDescription&)>;

void ForEachCommand(const CommandDescription& command, const Visit& visit) {
  visit(command);
  for (const CommandDescription& below : command.commands) ForEachCommand(below, visit);
}

std::string WithSpaces(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

std::string JoinedPath(const CommandDescription& command) {
  return WithSpaces(command.words);
}

std::vector<std::string> NamesOf(const CommandDescription& command) {
  std::vector<std::string> names;
  for (const OptionDescription& option : command.options) {
    if (option.positional || IsHidden(option)) continue;
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

/// In single quotes, on one line.
std::string ForPosix(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text)
    quoted += c == '\'' ? "'\\''" : std::string(1, c == '\n' ? ' ' : c);
  return quoted + "'";
}

/// The same for fish, which knows escapes inside of single quotes.
std::string ForFish(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') quoted += '\\';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "'";
}

/// "name:meaning" of zsh, where a colon of the name is escaped.
std::string Described(const std::string& name, const std::string& meaning) {
  std::string text;
  for (const char c : name) text += c == ':' ? "\\:" : std::string(1, c);
  return ForPosix(text + ":" + meaning);
}

/// The branch of a case statement that follows the words typed so far: 'a b') at='a b' ;;
std::string BranchesOfPaths(const CommandDescription& root) {
  std::string text;
  ForEachCommand(root, [&](const CommandDescription& command) {
    if (command.words.empty()) return;
    const CommandDescription& c = command;
    text += fmt::format("      {}) at={} ;;\n",
                        ForPosix((c.words.size() == 1 ? " " : "") + JoinedPath(c)),
                        ForPosix(JoinedPath(c)));
  });
  return text;
}

/// Branches for "PATH OPTION" of options that have choices.
std::string BranchesOfChoices(const CommandDescription& root,
                              const std::function<std::string(std::string)>& action) {
  std::string text;
  ForEachCommand(root, [&](const CommandDescription& command) {
    for (const OptionDescription& option : command.options) {
      if (option.positional || option.choices.empty() || IsHidden(option)) continue;
      for (const std::string& name : option.names) {
        text += fmt::format("    {}) {} ;;\n", ForPosix(JoinedPath(command) + " " + name),
                            action(WithSpaces(option.choices)));
      }
    }
  });
  return text;
}

/// A name for the shell's function: dashes are not allowed in all of them.
std::string FunctionOf(const std::string& program) {
  std::string name = "_" + program;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

/// Commands below each command, and its options, of bash.
std::string BashTables(const CommandDescription& root) {
  std::string text;
  ForEachCommand(root, [&](const CommandDescription& command) {
    std::vector<std::string> below;
    for (const auto& next : command.commands) below.push_back(next.words.back());
    text +=
        fmt::format("    {}) commands={} options={} ;;\n", ForPosix(JoinedPath(command)),
                    ForPosix(WithSpaces(below)), ForPosix(WithSpaces(NamesOf(command))));
  });
  return text;
}

/// The same of zsh, with their meanings.
std::string ZshTables(const CommandDescription& root) {
  std::string text;
  ForEachCommand(root, [&](const CommandDescription& command) {
    std::vector<std::string> below, options;
    for (const auto& next : command.commands)
      below.push_back(Described(next.words.back(), next.purpose));
    for (const OptionDescription& option : command.options) {
      if (option.positional || IsHidden(option)) continue;
      for (const auto& name : option.names)
        options.push_back(Described(name, option.meaning));
    }
    text += fmt::format("    {})\n      commands=({})\n      options=({})\n      ;;\n",
                        ForPosix(JoinedPath(command)), WithSpaces(below),
                        WithSpaces(options));
  });
  return text;
}

std::string FishOption(const OptionDescription& option) {
  std::string text;
  for (const auto& name : option.names) {
    const bool is_long = name.starts_with("--");
    text += fmt::format(" -{} {}", is_long ? 'l' : 's', name.substr(is_long ? 2 : 1));
  }
  if (!option.choices.empty()) {
    text += " -x -a " + ForFish(WithSpaces(option.choices));
  } else if (!option.value.empty()) {
    text += " -r";
  }
  return text + " -d " + ForFish(option.meaning);
}

constexpr char kBash[] =
    R"(# bash completion of {program}, made from its tables of commands and options
{function}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local at='' word choices='' commands='' options=''
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "$at $word" in
{paths}      *) ;;
    esac
  done
  # The shell takes the = of --option=value for a word.
  if [[ $current == '=' ]]; then
    current=''
  elif [[ $before == '=' ]]; then
    before=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  case "$at $before" in
{choices}    *) ;;
  esac
  case "$at" in
{tables}  esac
  if [[ -n $choices ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$current")
  elif [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
  else
    mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$current")
  fi
}}
complete -o bashdefault -o default -F {function} {program}
)";

constexpr char kZsh[] = R"(#compdef {program}
# zsh completion of {program}, made from its tables of commands and options
{function}() {{
  local at='' word
  local -a commands options
  for word in "${{(@)words[2,CURRENT-1]}}"; do
    case "$at $word" in
{paths}      *) ;;
    esac
  done
  case "$at ${{words[CURRENT-1]}}" in
{choices}    *) ;;
  esac
  case "$at" in
{tables}  esac
  if [[ ${{words[CURRENT]}} == -* ]]; then
    _describe -o 'option' options
  elif (( ${{#commands}} )); then
    _describe 'command' commands
  else
    _files
  fi
}}
{function} "$@"
)";

}  // namespace

std::string BashCompletion(const std::string& program, const CommandDescription& root) {
  const auto offer = [](const std::string& words) {
    return "choices=" + ForPosix(words);
  };
  return fmt::format(kBash, fmt::arg("program", program),
                     fmt::arg("function", FunctionOf(program)),
                     fmt::arg("paths", BranchesOfPaths(root)),
                     fmt::arg("choices", BranchesOfChoices(root, offer)),
                     fmt::arg("tables", BashTables(root)));
}

std::string ZshCompletion(const std::string& program, const CommandDescription& root) {
  const auto offer = [](const std::string& words) {
    return fmt::format("compadd -- {}; return", words);
  };
  return fmt::format(kZsh, fmt::arg("program", program),
                     fmt::arg("function", FunctionOf(program)),
                     fmt::arg("paths", BranchesOfPaths(root)),
                     fmt::arg("choices", BranchesOfChoices(root, offer)),
                     fmt::arg("tables", ZshTables(root)));
}

std::string FishCompletion(const std::string& program, const CommandDescription& root) {
  std::string text = fmt::format(
      "# fish completion of {}, made from its tables of commands and options\n", program);
  ForEachCommand(root, [&](const CommandDescription& command) {
    std::string at, below;
    for (const auto& word : command.words)
      at += (at.empty() ? "" : "; and ") + ("__fish_seen_subcommand_from " + word);
    for (const auto& next : command.commands) below += " " + next.words.back();
    const std::string here =
        (at.empty() ? "" : at + "; and ") + "not __fish_seen_subcommand_from" + below;
    for (const auto& next : command.commands) {
      text += fmt::format("complete -c {} -f -n {} -a {} -d {}\n", program, ForFish(here),
                          next.words.back(), ForFish(next.purpose));
    }
    const std::string condition = at.empty() ? "" : " -n " + ForFish(at);
    for (const OptionDescription& option : command.options) {
      if (option.positional || IsHidden(option)) continue;
      text += fmt::format("complete -c {}{}{}\n", program, condition, FishOption(option));
    }
  });
  return text;
}

}  // namespace intaglio::command_line
