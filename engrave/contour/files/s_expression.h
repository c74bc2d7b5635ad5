#pragma once

// Reads s-expressions: lists in round brackets of atoms, strings in quotes and lists.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::contour {

class SExpressions;

/// One list or atom; valid as long as what it was read from.
class SExpression {
 public:
  bool is_list() const;
  std::size_t line() const;  ///< where it begins, from 1
  /// An atom's text, a string's without quotes and escapes; empty for a list.
  std::string text() const;
  /// The text of a list's first item: "segment"; empty where that is a list.
  std::string_view name() const;
  /// All items of a list, its name among them.
  std::vector<SExpression> items() const;
  /// The first item that is a list of this name.
  std::optional<SExpression> Find(std::string_view name) const;
  /// The text of the item with this number, the name being 0; empty where there is none.
  std::string Text(std::size_t number) const;
  /// Nothing where there is no such item or it is no finite number.
  std::optional<double> Number(std::size_t number) const;

 private:
  friend class SExpressions;
  SExpression(const SExpressions* all, std::uint32_t index) : all_(all), index_(index) {}
  const SExpressions* all_;
  std::uint32_t index_;
};

struct SExpressionLimits {
  std::uint64_t max_expressions = 20'000'000;  ///< beyond them: kTooLarge
  int max_nesting = 100;
};

class SExpressions {
 public:
  /// One list. `text` outlives the result. Errors name the line: kUnreadable (no list,
  /// brackets or quotes that do not match), kTooLarge.
  static Result<SExpressions> Read(std::string_view text, std::string_view name,
                                   const SExpressionLimits& limits = {});
  SExpression root() const { return {this, 0}; }

 private:
  friend class SExpression;
  static constexpr std::uint32_t kNone = UINT32_MAX;
  struct Node {
    std::string_view text;
    std::uint32_t first = kNone;  ///< item of a list
    std::uint32_t next = kNone;   ///< in the same list
    std::uint32_t line = 0;
    bool list = false;
    bool quoted = false;
  };
  std::vector<Node> nodes_;
};

}  // namespace intaglio::contour
