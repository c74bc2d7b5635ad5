#include "materials_db/near_names.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace intaglio::materials_db {
namespace {

constexpr std::size_t kMinContained = 3;

/// Letters in lower case, digits, and what is not ASCII.
std::string Essence(std::string_view name) {
  std::string essence;
  for (const char c : name) {
    if (c >= 'A' && c <= 'Z') {
      essence += static_cast<char>(c - 'A' + 'a');
    } else if (c != ' ' && c != '-' && c != '_') {
      essence += c;
    }
  }
  return essence;
}

/// Levenshtein's distance: insertions, deletions and exchanges of one character.
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t exchanged = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({exchanged, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::vector<std::string> NearNames(std::string_view asked,
                                   std::span<const std::string> names,
                                   std::size_t max_count) {
  const std::string wanted = Essence(asked);
  const std::size_t max_edits = wanted.size() <= 3 ? 1 : 2;
  std::vector<std::tuple<std::size_t, std::string>> near;
  for (const std::string& name : names) {
    const std::string known = Essence(name);
    if (known.empty()) continue;
    const std::string_view shorter = known.size() < wanted.size() ? known : wanted;
    const std::string_view longer = known.size() < wanted.size() ? wanted : known;
    const bool contained =
        shorter.size() >= kMinContained && longer.find(shorter) != std::string_view::npos;
    if (!contained && longer.size() - shorter.size() > max_edits) continue;
    const std::size_t edits = EditDistance(wanted, known);
    if (contained || edits <= max_edits) near.emplace_back(edits, name);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::string> nearest;
  for (const auto& [edits, name] : near) {
    if (nearest.size() == max_count) break;
    nearest.push_back(name);
  }
  return nearest;
}

}  // namespace intaglio::materials_db
