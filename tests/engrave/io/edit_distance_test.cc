#include "engrave/io/edit_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

namespace intaglio::io {
namespace {

/// The definition, by recursion: the last bytes are deleted, inserted, matched or
/// exchanged, or the last two have changed places.
std::size_t ByRecursion(std::string_view a, std::string_view b) {
  if (a.empty() || b.empty()) return a.size() + b.size();
  const auto without = [](std::string_view text, std::size_t count) {
    return text.substr(0, text.size() - count);
  };
  std::size_t smallest = std::min(
      {ByRecursion(without(a, 1), b) + 1, ByRecursion(a, without(b, 1)) + 1,
       ByRecursion(without(a, 1), without(b, 1)) + (a.back() == b.back() ? 0 : 1)});
  if (a.size() > 1 && b.size() > 1 && a.back() == b[b.size() - 2] &&
      b.back() == a[a.size() - 2]) {
    smallest = std::min(smallest, ByRecursion(without(a, 2), without(b, 2)) + 1);
  }
  return smallest;
}

TEST(EditDistance, IsTheMinNumberOfEdits) {
  std::mt19937 random(3);
  const auto text = [&] {
    std::string letters(random() % 6, ' ');
    for (char& c : letters) c = static_cast<char>('a' + random() % 3);
    return letters;
  };
  for (int run = 0; run < 300; ++run) {
    const std::string a = text(), b = text();
    EXPECT_EQ(EditDistance(a, b), ByRecursion(a, b)) << a << " " << b;
    EXPECT_EQ(EditDistance(a, b), EditDistance(b, a)) << a << " " << b;
  }
}

TEST(EditDistance, KnownNames) {
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(EditDistance("sumbit", "submit"), 1u);
  EXPECT_EQ(EditDistance("ca", "abc"), 3u) << "no byte is edited twice";
  EXPECT_EQ(EditDistance("", "abc"), 3u);
}

}  // namespace
}  // namespace intaglio::io
