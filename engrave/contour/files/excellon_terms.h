#pragma once

// Lines of Excellon files as letters with numbers.

#include <algorithm>
#include <string_view>
#include <vector>

namespace intaglio::contour {

/// Places and lengths beyond are taken for a wrong unit.
inline constexpr double kMaxExcellon_mm = 10'000;

/// Letters with numbers: "X1Y2" is X 1, Y 2. A letter may have none.
struct Term {
  char letter = 0;
  std::string_view number;
};

/// Empty: the line is none of letters with numbers.
inline std::vector<Term> TermsOf(std::string_view line) {
  constexpr std::size_t kMaxTerms = 16;
  std::vector<Term> terms;
  while (!line.empty()) {
    const std::size_t end =
        std::min(line.find_first_not_of("0123456789.+-", 1), line.size());
    if (line[0] < 'A' || line[0] > 'Z' || terms.size() == kMaxTerms) return {};
    terms.push_back({line[0], line.substr(1, end - 1)});
    line.remove_prefix(end);
  }
  return terms;
}

}  // namespace intaglio::contour
