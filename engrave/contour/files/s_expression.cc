#include "engrave/contour/files/s_expression.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "engrave/io/number_text.h"

namespace intaglio::contour {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

std::string Unescaped(std::string_view text) {
  std::string plain;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] == '\\' && k + 1 < text.size()) {
      ++k;
      plain += text[k] == 'n' ? '\n' : text[k] == 't' ? '\t' : text[k];
    } else {
      plain += text[k];
    }
  }
  return plain;
}

struct Token {
  std::string_view text;
  std::size_t end = 0;
};

/// A bracket, a string without its quotes, or an atom; counts lines. Nothing for a string
/// that does not end.
std::optional<Token> TokenAt(std::string_view text, std::size_t at, std::uint32_t& line) {
  std::size_t end = at + 1;
  if (text[at] == '(') return Token{{}, end};
  if (text[at] != '"') {
    while (end < text.size() && !IsBlank(text[end]) && text[end] != '(' &&
           text[end] != ')')
      ++end;
    return Token{text.substr(at, end - at), end};
  }
  for (; end < text.size() && text[end] != '"'; ++end) {
    if (text[end] == '\n') ++line;
    if (text[end] == '\\') ++end;
  }
  if (end >= text.size()) return std::nullopt;
  return Token{text.substr(at + 1, end - at - 1), end + 1};
}

tl::unexpected<Error> TooManyExpressions(std::string_view name, std::uint32_t line,
                                         const SExpressionLimits& limits) {
  return Fail(ErrorCode::kTooLarge,
              fmt::format("{}: line {}: more than {} expressions or {} in each other; "
                          "divide the board",
                          name, line, limits.max_expressions, limits.max_nesting));
}

tl::unexpected<Error> WrongBrackets(std::string_view name, std::uint32_t line,
                                    const char* what) {
  return Fail(ErrorCode::kUnreadable,
              fmt::format("{}: line {}: {}; the file is damaged or of another kind", name,
                          line, what));
}

}  // namespace

bool SExpression::is_list() const { return all_->nodes_[index_].list; }
std::size_t SExpression::line() const { return all_->nodes_[index_].line; }

std::string SExpression::text() const {
  const auto& node = all_->nodes_[index_];
  return node.quoted ? Unescaped(node.text) : std::string(node.text);
}

std::string_view SExpression::name() const {
  const std::uint32_t first = all_->nodes_[index_].first;
  return first == SExpressions::kNone ? std::string_view() : all_->nodes_[first].text;
}

std::vector<SExpression> SExpression::items() const {
  std::vector<SExpression> items;
  for (std::uint32_t k = all_->nodes_[index_].first; k != SExpressions::kNone;
       k = all_->nodes_[k].next)
    items.push_back(SExpression(all_, k));
  return items;
}

std::optional<SExpression> SExpression::Find(std::string_view name) const {
  for (std::uint32_t k = all_->nodes_[index_].first; k != SExpressions::kNone;
       k = all_->nodes_[k].next) {
    const SExpression item(all_, k);
    if (item.is_list() && item.name() == name) return item;
  }
  return std::nullopt;
}

std::string SExpression::Text(std::size_t number) const {
  std::uint32_t k = all_->nodes_[index_].first;
  for (; k != SExpressions::kNone && number > 0; --number) k = all_->nodes_[k].next;
  return k == SExpressions::kNone ? std::string() : SExpression(all_, k).text();
}

std::optional<double> SExpression::Number(std::size_t number) const {
  return io::ParseFinite(Text(number));
}

Result<SExpressions> SExpressions::Read(std::string_view text, std::string_view name,
                                        const SExpressionLimits& limits) {
  SExpressions all;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;  // list and its last item
  std::uint32_t line = 1;
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '\n') ++line;
    if (IsBlank(text[at])) {
      ++at;
      continue;
    }
    if (open.empty() && !all.nodes_.empty())
      return WrongBrackets(name, line, "text behind the last bracket");
    if (open.empty() && text[at] != '(')
      return WrongBrackets(name, line, "expected a list such as (kicad_pcb ...)");
    if (text[at] == ')') {
      ++at;
      open.pop_back();
      continue;
    }
    if (all.nodes_.size() >= limits.max_expressions ||
        open.size() >= static_cast<std::size_t>(limits.max_nesting))
      return TooManyExpressions(name, line, limits);
    Node node;
    node.line = line;
    const auto token = TokenAt(text, at, line);
    if (!token) return WrongBrackets(name, node.line, "an open string");
    node.text = token->text;
    node.list = text[at] == '(';
    node.quoted = text[at] == '"';
    at = token->end;
    const auto index = static_cast<std::uint32_t>(all.nodes_.size());
    if (!open.empty()) {
      auto& [list, last] = open.back();
      (last == kNone ? all.nodes_[list].first : all.nodes_[last].next) = index;
      last = index;
    }
    all.nodes_.push_back(node);
    if (node.list) open.emplace_back(index, kNone);
  }
  if (!open.empty() || all.nodes_.empty())
    return WrongBrackets(name, line, "a bracket is not closed");
  return all;
}

}  // namespace intaglio::contour
