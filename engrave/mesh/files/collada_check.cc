#include "engrave/mesh/files/collada_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/io/number_text.h"

namespace intaglio::mesh {
namespace {

constexpr std::string_view kBlank = " \t\r\n";

/// visit(attributes, where the tag ends) of each tag of the name; until one returns
/// false.
template <typename Visit>
void ForEachTag(std::string_view text, std::string_view name, Visit&& visit) {
  const std::string begin = fmt::format("<{}", name);
  for (std::size_t at = text.find(begin); at != std::string_view::npos;
       at = text.find(begin, at)) {
    at += begin.size();
    if (at < text.size() && kBlank.find(text[at]) == std::string_view::npos) continue;
    const std::size_t end = std::min(text.find('>', at), text.size());
    if (!visit(text.substr(at, end - at), end)) return;
    at = end;
  }
}

/// The first of the name, as it is written.
std::optional<std::string_view> Attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos;
       at = tag.find(name, at)) {
    const bool begins = at > 0 && kBlank.find(tag[at - 1]) != std::string_view::npos;
    at += name.size();
    const std::size_t equals = tag.find_first_not_of(kBlank, at);
    if (!begins || equals == std::string_view::npos || tag[equals] != '=') continue;
    const std::size_t quote = tag.find_first_not_of(kBlank, equals + 1);
    if (quote == std::string_view::npos) return std::nullopt;
    const std::size_t end = tag.find(tag[quote], quote + 1);
    if ((tag[quote] != '"' && tag[quote] != '\'') || end == std::string_view::npos)
      return std::nullopt;
    return tag.substr(quote + 1, end - quote - 1);
  }
  return std::nullopt;
}

/// Nothing when it is not a whole number; `missing` when the attribute is not there.
std::optional<std::uint64_t> NumberOf(std::string_view tag, std::string_view name,
                                      std::optional<std::uint64_t> missing) {
  const auto text = Attribute(tag, name);
  if (!text) return missing;
  std::uint32_t number = 0;
  const auto [end, error] =
      std::from_chars(text->data(), text->data() + text->size(), number);
  if (error != std::errc() || end != text->data() + text->size()) return std::nullopt;
  return number;
}

bool HasBadIndexList(std::string_view text) {
  constexpr std::string_view kBegin = "<p>";
  for (std::size_t at = text.find(kBegin); at != std::string_view::npos;
       at = text.find(kBegin, at)) {
    at += kBegin.size();
    const std::size_t end = text.find('<', at);
    if (text.substr(at, end - at).find_first_not_of("0123456789- \t\r\n") !=
        std::string_view::npos) {
      return true;
    }
  }
  return false;
}

/// How many numbers each array has; of two with one name the fewer.
std::optional<std::map<std::string_view, std::uint64_t>> ArraysOf(std::string_view text) {
  std::map<std::string_view, std::uint64_t> arrays;
  bool good = true;
  ForEachTag(text, "float_array", [&](std::string_view tag, std::size_t) {
    const auto id = Attribute(tag, "id");
    const auto count = NumberOf(tag, "count", std::nullopt);
    good = count.has_value();
    if (good && id) {
      const auto known = arrays.emplace(*id, *count).first;
      known->second = std::min(known->second, *count);
    }
    return good;
  });
  return good ? std::optional(std::move(arrays)) : std::nullopt;
}

}  // namespace

std::string WrongInCollada(std::string_view text) {
  if (HasBadIndexList(text))
    return "a list of indices contains something other than numbers";
  const auto arrays = ArraysOf(text);
  if (!arrays) return "an array of numbers has no count";
  std::string wrong;
  ForEachTag(text, "accessor", [&](std::string_view tag, std::size_t end) {
    const auto source = Attribute(tag, "source");
    if (!source || source->empty()) return true;  // the library refuses it
    const auto array = arrays->find(source->substr(1));
    if (array == arrays->end()) return true;  // of names, or the library refuses it
    const auto count = NumberOf(tag, "count", std::nullopt);
    const auto stride = NumberOf(tag, "stride", 1), offset = NumberOf(tag, "offset", 0);
    std::uint64_t read = 0;
    // To its end, or to the next one: it may have no inside.
    const std::string_view inside = text.substr(end, text.find("accessor", end) - end);
    ForEachTag(inside, "param",
               [&](std::string_view, std::size_t) { return ++read > 0; });
    if (!count || !stride || !offset) {
      wrong = "an accessor has no source";
    } else if (*count > 0 && *offset + (*count - 1) * *stride + std::max(*stride, read) >
                                 array->second) {
      wrong = fmt::format("an accessor exceeds the {} of '{}'",
                          Counted(array->second, "number"), array->first);
    }
    return wrong.empty();
  });
  return wrong;
}

UpAxis UpAxisInCollada(std::string_view text) {
  const std::size_t tag = text.find("<up_axis");
  if (tag == std::string_view::npos) return UpAxis::kY;
  const std::size_t inside = text.find('>', tag);
  if (inside == std::string_view::npos) return UpAxis::kY;
  const std::size_t begin = text.find_first_not_of(kBlank, inside + 1);
  if (begin == std::string_view::npos) return UpAxis::kY;
  const std::string_view value = text.substr(begin);
  if (value.starts_with("Z_UP")) return UpAxis::kZ;
  return value.starts_with("X_UP") ? UpAxis::kX : UpAxis::kY;
}

std::optional<double> UnitInCollada_mm(std::string_view text) {
  constexpr double kMetre_mm = 1000;
  std::optional<double> unit_mm;
  ForEachTag(text, "unit", [&](std::string_view tag, std::size_t) {
    const auto metres = Attribute(tag, "meter");
    const auto number = metres ? io::ParseFinite(*metres) : std::nullopt;
    if (number && *number > 0) unit_mm = *number * kMetre_mm;
    return false;
  });
  return unit_mm;
}

}  // namespace intaglio::mesh
