#include "services/platform/command_line/joined_values.h"

#include <algorithm>
#include <string_view>

#include "engrave/io/number_text.h"

namespace intaglio::command_line {
namespace {

constexpr std::string_view kSeparators[] = {"x", "X", "\u00d7", ","};

/// The numbers of a word, as text; none when it is not several numbers.
std::vector<std::string> NumbersIn(std::string_view word) {
  std::vector<std::string> numbers(1);
  while (!word.empty()) {
    const auto separator = std::find_if(
        std::begin(kSeparators), std::end(kSeparators),
        [word](std::string_view s) { return word.substr(0, s.size()) == s; });
    if (separator != std::end(kSeparators)) {
      numbers.emplace_back();
      word.remove_prefix(separator->size());
    } else {
      numbers.back() += word.front();
      word.remove_prefix(1);
    }
  }
  const bool all_numbers = std::all_of(
      numbers.begin(), numbers.end(),
      [](const std::string& text) { return io::ParseFinite(text).has_value(); });
  return numbers.size() > 1 && all_numbers ? numbers : std::vector<std::string>();
}

}  // namespace

std::vector<std::string> DivideJoinedValues(const std::vector<std::string>& words,
                                            const std::set<std::string>& options) {
  std::vector<std::string> divided;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const bool assigned =
        equals != std::string::npos && options.count(word.substr(0, equals)) != 0;
    const bool follows = !divided.empty() && options.count(divided.back()) != 0;
    const auto numbers = assigned  ? NumbersIn(word.substr(equals + 1))
                         : follows ? NumbersIn(word)
                                   : std::vector<std::string>();
    if (numbers.empty()) {
      divided.push_back(word);
      continue;
    }
    if (assigned) divided.push_back(word.substr(0, equals));
    divided.insert(divided.end(), numbers.begin(), numbers.end());
  }
  return divided;
}

}  // namespace intaglio::command_line
