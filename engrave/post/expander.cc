#include <fmt/format.h>

#include <cmath>

#include "engrave/core/check.h"
#include "engrave/post/template.h"

namespace intaglio::post {

void AppendNumber(double value, const NumberFormat& format, std::string& text) {
  Require(std::isfinite(value), "a program cannot hold {}", value);
  const std::size_t begin = text.size();
  text += fmt::format("{:.{}f}", value * format.scale, format.decimals);
  if (format.trim && format.decimals > 0) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  if (text[begin] == '-' && text.find_first_of("123456789", begin) == std::string::npos) {
    text.erase(begin, 1);
  }
}

void Expander::Append(std::size_t fragment, std::span<const Value> values,
                      std::string& text) {
  const FragmentRule& rule = rules_.fragments[fragment];
  Require(values.size() == rule.variables.size(), "fragment {} has {} variables, got {}",
          rule.name, rule.variables.size(), values.size());
  for (const Piece& piece : program_.fragments.at(fragment).pieces) {
    text += piece.text;
    if (piece.variable < 0) continue;
    const auto place = static_cast<std::size_t>(piece.variable);
    const std::string_view name = rule.variables[place];
    if (name == "N") {
      text += std::to_string(++lines_);
    } else if (const auto* number = std::get_if<double>(&values[place])) {
      AppendNumber(*number, program_.FormatOf(name), text);
    } else if (const auto* count = std::get_if<std::uint64_t>(&values[place])) {
      text += std::to_string(*count);
    } else {
      text += std::get<std::string_view>(values[place]);
    }
  }
}

}  // namespace intaglio::post
