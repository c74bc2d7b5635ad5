#include "engrave/io/nearest_name.h"

#include <algorithm>

#include "engrave/io/edit_distance.h"

namespace intaglio::io {
namespace {

constexpr std::size_t kMaxEdits = 2;

}  // namespace

std::optional<std::string> NearestName(const std::string& word,
                                       const std::vector<std::string>& known) {
  std::optional<std::string> nearest;
  std::size_t smallest = std::min(kMaxEdits + 1, (word.size() + 1) / 2);
  for (const std::string& candidate : known) {
    const std::size_t edits = EditDistance(word, candidate);
    if (edits >= smallest) continue;
    smallest = edits;
    nearest = candidate;
  }
  return nearest;
}

}  // namespace intaglio::io
