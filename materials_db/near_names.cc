#include "materials_db/near_names.h"

#include <algorithm>
#include <tuple>

#include "engrave/io/edit_distance.h"
#include "engrave/io/lower_case.h"

namespace intaglio::materials_db {
namespace {

constexpr std::size_t kMinContained = 3;

}  // namespace

std::string SpellingOf(std::string_view name) {
  std::string spelling;
  for (const char c : name) {
    if (c != ' ' && c != '-' && c != '_') spelling += io::LowerCase(c);
  }
  return spelling;
}

std::vector<std::string> NearNames(std::string_view asked,
                                   std::span<const std::string> names,
                                   std::size_t max_count) {
  const std::string wanted = SpellingOf(asked);
  const std::size_t max_edits = wanted.size() <= 3 ? 1 : 2;
  std::vector<std::tuple<std::size_t, std::string>> near;
  for (const std::string& name : names) {
    const std::string known = SpellingOf(name);
    if (known.empty()) continue;
    const std::string_view shorter = known.size() < wanted.size() ? known : wanted;
    const std::string_view longer = known.size() < wanted.size() ? wanted : known;
    const bool contained =
        shorter.size() >= kMinContained && longer.find(shorter) != std::string_view::npos;
    if (!contained && longer.size() - shorter.size() > max_edits) continue;
    const std::size_t edits = io::EditDistance(wanted, known);
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
