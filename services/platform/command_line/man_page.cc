#include "services/platform/command_line/man_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <string_view>

#include "services/platform/command_line/option_text.h"

namespace intaglio::command_line {
namespace {

/// Text that troff prints as it is: dashes that can be searched and copied, and no line
/// that begins as a request does.
std::string Plain(const std::string& text) {
  std::string plain;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) plain += "\\&";
    line_begins = c == '\n';
    switch (c) {
      case '\\':
        plain += "\\e";
        break;
      case '-':
        plain += "\\-";
        break;
      case '`':
        plain += "\\(ga";
        break;
      case '^':
        plain += "\\(ha";
        break;
      case '~':
        plain += "\\(ti";
        break;
      default:
        plain += c;
    }
  }
  return plain;
}

std::string Bold(const std::string& text) { return "\\fB" + Plain(text) + "\\fR"; }
std::string Italic(const std::string& text) { return "\\fI" + Plain(text) + "\\fR"; }

std::string Capitals(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string Quoted(std::string title) {
  std::replace(title.begin(), title.end(), '"', '\'');
  return '"' + Plain(title) + '"';
}

/// A heading, without the colon that --help puts behind it.
std::string Heading(const char* macro, std::string title) {
  if (title.ends_with(':')) title.pop_back();
  return fmt::format("{} {}\n", macro, Quoted(title));
}

std::string TagOf(const OptionDescription& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) {
    names.push_back(option.positional ? Italic(name) : Bold(name));
  }
  std::string tag = fmt::format("{}", fmt::join(names, ", "));
  const std::string value = option.positional ? "" : PlaceholderOf(option);
  if (!value.empty()) tag += " " + Italic(value);
  if (option.repeatable) tag += " ...";
  return tag;
}

std::string Sentence(std::string text) {
  if (!text.empty() && text.back() != '.') text += '.';
  return text;
}

std::string OptionText(const OptionDescription& option) {
  std::string text = Sentence(option.meaning);
  const auto add = [&text](const char* label, const std::string& value) {
    if (!value.empty()) text += fmt::format(" {}: {}.", label, value);
  };
  if (option.required && !option.positional) text += " Required.";
  add("One of", fmt::format("{}", fmt::join(option.choices, ", ")));
  add("Range", RangeOf(option));
  add("Default", option.default_value);
  add("Environment", option.variable);
  return fmt::format(".TP\n{}\n{}\n", TagOf(option), Plain(text));
}

/// Options in the order of --help, under `macro` with the group as the heading.
std::string OptionsText(const std::vector<OptionDescription>& options,
                        const char* macro) {
  std::vector<std::string> groups;
  std::map<std::string, std::string> text_of;
  for (const OptionDescription& option : options) {
    if (IsHidden(option)) continue;
    const std::string group = option.positional ? "Arguments" : option.group;
    if (!text_of.contains(group)) groups.push_back(group);
    text_of[group] += OptionText(option);
  }
  std::string text;
  const bool of_page = std::string_view(macro) == ".SH";
  for (const std::string& group : groups)
    text += Heading(macro, of_page ? Capitals(group) : group) + text_of[group];
  return text;
}

std::string Synopsis(const std::string& path, const CommandDescription& command) {
  std::string text = Bold(path);
  const bool has_options = std::any_of(
      command.options.begin(), command.options.end(),
      [](const auto& option) { return !option.positional && !IsHidden(option); });
  if (has_options) text += " [" + Italic("OPTION") + "]...";
  if (!command.commands.empty()) text += " " + Italic("COMMAND") + " ...";
  for (const OptionDescription& option : command.options) {
    if (!option.positional) continue;
    std::string name = Italic(option.names.front());
    if (option.repeatable) name += "...";
    text += option.required ? " " + name : " [" + name + "]";
  }
  return text + "\n";
}

std::string FooterText(const std::string& footer, const char* macro) {
  if (footer.empty()) return "";
  std::string text = Plain(footer);
  while (text.ends_with('\n')) text.pop_back();
  return fmt::format("{} \"NOTES\"\n.nf\n{}\n.fi\n", macro, text);
}

/// The commands below the command of a page, each with its options.
std::string SectionsOf(const std::string& path, const CommandDescription& command) {
  std::string text;
  for (const CommandDescription& below : command.commands) {
    const std::string name = path + " " + below.words.back();
    text += Heading(".SH", name) + Plain(Sentence(below.purpose)) + "\n.PP\n" +
            Synopsis(name, below) + OptionsText(below.options, ".SS") +
            FooterText(below.footer, ".SS") + SectionsOf(name, below);
  }
  return text;
}

std::string Head(const std::string& page, const std::string& path,
                 const CommandDescription& command) {
  std::string purpose = command.purpose;
  std::replace(purpose.begin(), purpose.end(), '\n', ' ');
  return fmt::format(
      ".\\\" Made from the program's tables of commands and options.\n"
      ".TH {} 1 \"\" \"Intaglio\" \"User Commands\"\n"
      ".nh\n.ad l\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}.SH DESCRIPTION\n{}\n",
      Quoted(Capitals(page)), Plain(page), Plain(purpose), Synopsis(path, command),
      Plain(Sentence(purpose)));
}

std::string References(const std::vector<std::string>& pages) {
  std::vector<std::string> names;
  for (const std::string& page : pages) names.push_back(Bold(page) + "(1)");
  if (names.empty()) return "";
  return fmt::format(".SH \"SEE ALSO\"\n{}\n", fmt::join(names, ",\n"));
}

}  // namespace

std::vector<ManPage> ManPagesOf(const std::string& program,
                                const CommandDescription& description) {
  std::vector<ManPage> pages;
  std::vector<std::string> names;
  std::string commands;
  for (const CommandDescription& command : description.commands) {
    const std::string name = program + "-" + command.words.back();
    const std::string path = program + " " + command.words.back();
    names.push_back(name);
    commands += fmt::format(".TP\n{}\n{} See {}(1).\n", Bold(command.words.back()),
                            Plain(Sentence(command.purpose)), Bold(name));
    pages.push_back(
        {name + ".1", Head(name, path, command) + OptionsText(command.options, ".SH") +
                          SectionsOf(path, command) + FooterText(command.footer, ".SH") +
                          References({program})});
  }
  std::string text = Head(program, program, description);
  if (!commands.empty()) text += ".SH COMMANDS\n" + commands;
  text += OptionsText(description.options, ".SH") +
          FooterText(description.footer, ".SH") + References(names);
  pages.insert(pages.begin(), {program + ".1", std::move(text)});
  return pages;
}

}  // namespace intaglio::command_line
