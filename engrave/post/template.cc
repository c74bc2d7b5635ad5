#include "engrave/post/template.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/number_text.h"

namespace intaglio::post {
namespace {

constexpr std::size_t kMaxTemplateBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxParameter = 200;

std::vector<std::string_view> TokensOf(std::string_view line) {
  std::vector<std::string_view> tokens;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t", at);
    if (begin == std::string_view::npos) break;
    at = std::min(line.find_first_of(" \t", begin), line.size());
    tokens.push_back(line.substr(begin, at - begin));
  }
  return tokens;
}

template <typename Rules>
std::string NamesOf(const Rules& rules) {
  std::string names;
  for (const auto& rule : rules) {
    if (!names.empty()) names += ", ";
    if constexpr (requires { rule.name; }) {
      names += rule.name;
    } else {
      names += rule;
    }
  }
  return names;
}

/// Reads a template line by line.
class Reader {
 public:
  Reader(std::string_view file, const TemplateRules& rules, const Parameters& given)
      : rules_(rules), given_(given) {
    out_.file = file;
    out_.fragments.resize(rules.fragments.size());
    used_.resize(rules.fragments.size());
  }

  Result<Template> Read(std::string_view text) {
    text = io::WithoutByteOrderMark(text);
    while (!text.empty()) {
      ++line_number_;
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
      INTAGLIO_TRY(TakeLine(line));
    }
    INTAGLIO_TRY(RequireComplete());
    INTAGLIO_TRY(RequireUsed());
    return std::move(out_);
  }

 private:
  tl::unexpected<Error> Wrong(const std::string& what,
                              std::string_view value = {}) const {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: line {}: {}", out_.file, line_number_, what),
                std::string(value));
  }

  Status TakeLine(std::string_view line) {
    if (line.starts_with("##")) {
      line.remove_prefix(1);
    } else if (line.starts_with("#-")) {
      return {};
    } else if (line.starts_with("#parameter ")) {
      return TakeParameter(line.substr(line.find(' ')));
    } else if (line.starts_with('#')) {
      return TakeSetting(TokensOf(line.substr(1)));
    }
    if (fragment_) return TakeText(line);
    if (TokensOf(line).empty()) return {};
    return Wrong("text before the first #fragment; comments begin with #-", line);
  }

  Status TakeSetting(const std::vector<std::string_view>& tokens) {
    if (tokens.empty()) return Wrong("a lone '#'; write ## for a '#' of the program");
    if (tokens[0] == "number") return TakeNumber(tokens);
    if (tokens.size() != 2) {
      return Wrong(
          fmt::format("#{} needs one value, got {}", tokens[0], tokens.size() - 1));
    }
    if (tokens[0] == "fragment") return BeginFragment(tokens[1]);
    if (tokens[0] == "extension") {
      out_.extension = tokens[1];
      return {};
    }
    if (tokens[0] == "line-end") {
      if (tokens[1] != "lf" && tokens[1] != "crlf") {
        return Wrong(fmt::format("#line-end is lf or crlf, not '{}'", tokens[1]),
                     tokens[1]);
      }
      out_.line_end = tokens[1] == "lf" ? "\n" : "\r\n";
      return {};
    }
    return TakeRuled(tokens[0], tokens[1]);
  }

  Status TakeRuled(std::string_view name, std::string_view value) {
    const auto rule = std::ranges::find(rules_.settings, name, &SettingRule::name);
    if (rule == rules_.settings.end()) {
      return Wrong(
          fmt::format("unknown setting #{}; known: fragment, extension, line-end, "
                      "number, parameter{}{}",
                      name, rules_.settings.empty() ? "" : ", ",
                      NamesOf(rules_.settings)),
          name);
    }
    const auto number = io::ParseFinite(value);
    if (!number || *number < rule->min || *number > rule->max) {
      return Wrong(fmt::format("#{} is {}, has to be a number from {} to {}", name, value,
                               rule->min, rule->max),
                   value);
    }
    if (!out_.settings.emplace(name, *number).second) {
      return Wrong(fmt::format("#{} is given twice", name));
    }
    return {};
  }

  /// parameter NAME the rest of the line
  Status TakeParameter(std::string_view rest) {
    const auto tokens = TokensOf(rest);
    if (tokens.size() < 2) return Wrong("#parameter needs a name and a text");
    const std::string name(tokens[0]);
    const bool is_name = std::ranges::all_of(name, [](unsigned char c) {
      return std::isupper(c) != 0 || std::isdigit(c) != 0 || c == '_';
    });
    if (!is_name || IsKnown(name)) {
      return Wrong(
          fmt::format("#parameter {}: has to be capital letters, digits and '_', "
                      "and no variable",
                      name),
          name);
    }
    std::string text(
        rest.substr(static_cast<std::size_t>(tokens[1].data() - rest.data())));
    if (const auto given = given_.find(name); given != given_.end()) {
      if (io::ParseFinite(text) && !io::ParseFinite(given->second)) {
        return Wrong(fmt::format("parameter {} is {}, has to be a number as {}", name,
                                 given->second, text),
                     given->second);
      }
      text = given->second;
    }
    const bool is_line =
        std::ranges::all_of(text, [](unsigned char c) { return c >= ' ' && c != 0x7f; });
    if (text.empty() || text.size() > kMaxParameter || !is_line) {
      return Wrong(fmt::format("parameter {} has to be a text of one line, 1 to {} "
                               "characters",
                               name, kMaxParameter),
                   name);
    }
    if (!parameters_.emplace(name, ParameterText{text, line_number_}).second)
      return Wrong(fmt::format("#parameter: '{}' is given twice", name), name);
    out_.parameters.push_back(name);
    return {};
  }

  /// number X Y scale=1000 decimals=0
  Status TakeNumber(const std::vector<std::string_view>& tokens) {
    NumberFormat format;
    std::vector<std::string_view> variables;
    for (const std::string_view token : std::span(tokens).subspan(1)) {
      const std::size_t equals = token.find('=');
      if (equals == std::string_view::npos) {
        variables.push_back(token);
        continue;
      }
      INTAGLIO_TRY(TakeFormat(token.substr(0, equals), token.substr(equals + 1), format));
    }
    if (variables.empty()) return Wrong("#number names no variable");
    for (const std::string_view variable : variables) {
      if (!IsKnown(variable)) {
        return Wrong(fmt::format("#number: unknown variable '{}'", variable), variable);
      }
      if (!out_.numbers.emplace(variable, format).second) {
        return Wrong(fmt::format("#number: '{}' is given twice", variable), variable);
      }
      number_lines_.emplace(variable, line_number_);
    }
    return {};
  }

  Status TakeFormat(std::string_view name, std::string_view value, NumberFormat& format) {
    const auto number = io::ParseFinite(value);
    if (name == "scale" && number && *number >= 1e-6 && *number <= 1e9) {
      format.scale = *number;
      return {};
    }
    if (name == "decimals" && number && *number >= 0 && *number <= 9 &&
        *number == std::floor(*number)) {
      format.decimals = static_cast<int>(*number);
      return {};
    }
    if (name == "trim" && (value == "0" || value == "1")) {
      format.trim = value == "1";
      return {};
    }
    return Wrong(fmt::format("#number: '{}={}'; allowed are scale=1e-6..1e9, "
                             "decimals=0..9 and trim=0..1",
                             name, value),
                 value);
  }

  bool IsKnown(std::string_view variable) const {
    return std::ranges::any_of(rules_.fragments, [&](const FragmentRule& rule) {
      return std::ranges::find(rule.variables, variable) != rule.variables.end();
    });
  }

  Status BeginFragment(std::string_view name) {
    const auto rule = std::ranges::find(rules_.fragments, name, &FragmentRule::name);
    if (rule == rules_.fragments.end()) {
      return Wrong(fmt::format("unknown fragment '{}'; known: {}", name,
                               NamesOf(rules_.fragments)),
                   name);
    }
    fragment_ = static_cast<std::size_t>(rule - rules_.fragments.begin());
    if (!used_[*fragment_].empty()) {
      return Wrong(fmt::format("fragment '{}' is given twice", name), name);
    }
    used_[*fragment_].resize(rule->variables.size() + 1);  // the last: it was given
    return {};
  }

  Status TakeText(std::string_view line) {
    const FragmentRule& rule = rules_.fragments[*fragment_];
    std::vector<Piece>& pieces = out_.fragments[*fragment_].pieces;
    std::string text;
    for (std::size_t at = 0; at < line.size(); ++at) {
      if (line[at] != '@') {
        text += line[at];
        continue;
      }
      const std::size_t end = line.find('@', at + 1);
      if (end == std::string_view::npos) {
        return Wrong("an '@' without its second one; write @@ for an '@' of the program",
                     line);
      }
      const std::string_view name = line.substr(at + 1, end - at - 1);
      at = end;
      if (name.empty()) {
        text += '@';
        continue;
      }
      if (const auto found = parameters_.find(name); found != parameters_.end()) {
        text += found->second.text;
        found->second.used = true;
        continue;
      }
      const auto variable = std::ranges::find(rule.variables, name);
      if (variable == rule.variables.end()) {
        return Wrong(fmt::format("unknown variable @{}@; fragment '{}' has {}", name,
                                 rule.name, NamesOf(rule.variables)),
                     name);
      }
      const auto place = static_cast<std::size_t>(variable - rule.variables.begin());
      used_[*fragment_][place] = true;
      pieces.push_back({std::move(text), static_cast<int>(place)});
      text.clear();
    }
    pieces.push_back({text + out_.line_end, -1});
    return {};
  }

  Status RequireUsed() {
    for (const auto& [variable, line] : number_lines_) {
      if (AnyFragmentUses(out_, rules_, variable)) continue;
      line_number_ = line;
      return Wrong(
          fmt::format("#number: no fragment uses @{}@; remove the variable here, or use "
                      "it",
                      variable),
          variable);
    }
    for (const auto& [name, parameter] : parameters_) {
      if (parameter.used) continue;
      line_number_ = parameter.line;
      return Wrong(fmt::format("#parameter: no fragment uses @{}@; remove it", name),
                   name);
    }
    return {};
  }

  Status RequireComplete() const {
    for (std::size_t i = 0; i < rules_.fragments.size(); ++i) {
      const FragmentRule& rule = rules_.fragments[i];
      if (used_[i].empty()) {
        if (!rule.required) continue;
        return Wrong(fmt::format("the file ends without '#fragment {}'", rule.name));
      }
      for (const std::string_view needed : rule.needed) {
        const auto place = std::ranges::find(rule.variables, needed);
        if (used_[i].at(static_cast<std::size_t>(place - rule.variables.begin())))
          continue;
        return Wrong(fmt::format("fragment '{}' does not use @{}@, which would be lost",
                                 rule.name, needed),
                     needed);
      }
    }
    return {};
  }

  struct ParameterText {
    std::string text;
    int line = 0;
    bool used = false;
  };

  const TemplateRules& rules_;
  const Parameters& given_;
  std::map<std::string, ParameterText, std::less<>> parameters_;
  Template out_;
  std::vector<std::vector<bool>> used_;  ///< by fragment and variable; empty: not given
  std::map<std::string, int, std::less<>> number_lines_;  ///< of #number, by variable
  std::optional<std::size_t> fragment_;
  int line_number_ = 0;
};

}  // namespace

NumberFormat Template::FormatOf(std::string_view variable) const {
  const auto found = numbers.find(variable);
  return found == numbers.end() ? NumberFormat{} : found->second;
}

double Template::SettingOf(std::string_view name, double otherwise) const {
  const auto found = settings.find(name);
  return found == settings.end() ? otherwise : found->second;
}

bool UsesVariable(const Template& program, const TemplateRules& rules,
                  std::size_t fragment, std::string_view variable) {
  const auto& variables = rules.fragments[fragment].variables;
  return std::ranges::any_of(program.fragments[fragment].pieces, [&](const Piece& piece) {
    return piece.variable >= 0 &&
           variables[static_cast<std::size_t>(piece.variable)] == variable;
  });
}

bool AnyFragmentUses(const Template& program, const TemplateRules& rules,
                     std::string_view variable, std::size_t from) {
  for (std::size_t i = from; i < rules.fragments.size(); ++i) {
    if (UsesVariable(program, rules, i, variable)) return true;
  }
  return false;
}

Result<Template> ParseTemplate(std::string_view text, std::string_view file,
                               const TemplateRules& rules, const Parameters& given) {
  if (text.size() > kMaxTemplateBytes) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{}: {} bytes; a template has at most {}", file, text.size(),
                            kMaxTemplateBytes));
  }
  return Reader(file, rules, given).Read(text);
}

Status RequireParameters(std::span<const Template> programs, const Parameters& given) {
  std::vector<std::string> known;
  for (const Template& program : programs)
    known.insert(known.end(), program.parameters.begin(), program.parameters.end());
  for (const auto& [name, text] : given) {
    if (std::ranges::find(known, name) != known.end()) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("parameter {}: no template of this program has it; they "
                            "have {}",
                            name, known.empty() ? "none" : NamesOf(known)),
                name);
  }
  return {};
}

}  // namespace intaglio::post
