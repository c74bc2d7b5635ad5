#include "tests/walls/unreached.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <string_view>

#include "tests/walls/language.h"
#include "tests/walls/tree_files.h"

// clang-format puts the names of a declaration behind a type (`Type Name(`, `Type*
// Name(`, `Type Class::Name(`) or, of a constructor, at the beginning of its line; every
// other place of a name uses it.

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;

/// Unreached names that stay, and why.
const std::map<std::string, std::string> kStay = {
    // Rows of a table, for the tests that each of its rows has to pass.
    {"EndpointKinds", "rows for tests"},
    {"Profiles", "rows for tests"},
    {"SequencedTypes", "rows for tests"},
    // Called by the library nanoflann, by these names.
    {"addPoint", "nanoflann"},
    {"kdtree_get_bbox", "nanoflann"},
    {"kdtree_get_point_count", "nanoflann"},
    {"kdtree_get_pt", "nanoflann"},
    {"worstDist", "nanoflann"},
    // Called by the library Beast, by these names.
    {"async_teardown", "Beast"},
    {"beast_close_socket", "Beast"},
    // What tests compare with what a program uses.
    {"Ct5OfHead", "makes published files of a lens again"},
    {"FociOf", "the foci whose middle a program aims at"},
    {"MeltingBound", "the bound that docs/materials.md names"},
    {"ObliquePeakRatio", "what the table ObliqueLoss is made of"},
    {"ReadXy2Frame", "reads what Xy2Frame writes"},
    {"ReflectanceAtAngle", "what normal incidence neglects: docs/source_coverage.md"},
    {"SourceNodeSpeeds", "the published law beside ours: docs/measurements.md"},
    {"memory_s", "the memory of the stream in tests/published"},
    // What tests ask the virtual grbl, and how it began.
    {"Grbl11", "the controller with a small memory"},
    {"crashed", "virtual grbl"},
    {"lines_taken", "virtual grbl"},
    {"lost_bytes", "virtual grbl"},
    {"motion_powers", "virtual grbl"},
    {"now_us", "virtual grbl"},
    {"output_at", "virtual grbl"},
    {"output_on", "virtual grbl"},
    {"refuses", "virtual grbl"},
    {"resets_taken", "virtual grbl"},
    {"spindle_on", "virtual grbl"},
    {"steps_made", "virtual grbl"},
    // What tests need to ask or to begin with.
    {"AllAxes", "one drive for the axes of a test"},
    {"AsVector", "the command of a head as the numbers of a test"},
    {"Ideal", "a head that is measured in a test"},
    {"ParseMachine", "a profile without a file, for tests/fuzz"},
    {"has_place", "whether a client waited in vain"}};

bool IsBlank(char c) { return c == ' ' || c == '\n'; }

/// Where the qualified name begins whose last part begins at `at`.
std::size_t BeginOfQualified(std::string_view code, std::size_t at) {
  while (at >= 3 && code.substr(at - 2, 2) == "::" && IsOfName(code[at - 3])) {
    at -= 2;
    while (at > 0 && IsOfName(code[at - 1])) --at;
  }
  return at;
}

/// Whether what ends before `end` is a type.
bool EndsWithAType(std::string_view code, std::size_t end) {
  static const std::set<std::string, std::less<>> kNoTypes = {
      "return", "else", "new", "delete", "throw", "case", "co_return", "not"};
  while (end > 0 && IsBlank(code[end - 1])) --end;
  if (end < 2) return false;
  const char last = code[end - 1];
  // `Type*` and `Type>` end with them; an operator has a blank before it.
  if (last == '*' || last == '&' || last == '>')
    return !IsBlank(code[end - 2]) && code[end - 2] != '-' && code[end - 2] != '&';
  if (!IsOfName(last)) return false;
  auto begin = end;
  while (begin > 0 && IsOfName(code[begin - 1])) --begin;
  return !kNoTypes.contains(code.substr(begin, end - begin));
}

/// Whether the name in [at, end) is declared or defined here as a function.
bool IsDeclaration(std::string_view code, std::size_t at, std::size_t end) {
  const auto behind = code.find_first_not_of(" \n", end);
  if (behind == std::string_view::npos || code[behind] != '(') return false;
  const auto begin = BeginOfQualified(code, at);
  const bool at_line_begin = begin == 0 || code[begin - 1] == '\n';
  return (at_line_begin && begin < at) || EndsWithAType(code, begin);
}

struct Names {
  std::map<std::string, std::string> declared;  ///< in a header, with it
  std::set<std::string> used;
};

void AddNames(std::string_view code, const std::string& header, Names& names) {
  for (std::size_t at = 0; at < code.size();) {
    auto end = at;
    while (end < code.size() && IsOfName(code[end])) ++end;
    if (end > at && std::isdigit(static_cast<unsigned char>(code[at])) == 0) {
      const std::string name(code.substr(at, end - at));
      // `struct alignas(64) Leaf` looks like a function.
      if (name == "alignas" || !IsDeclaration(code, at, end))
        names.used.insert(name);
      else if (!header.empty())
        names.declared.emplace(name, header);
    }
    at = std::max(end, at + 1);
  }
}

}  // namespace

std::map<std::string, std::string> UnreachedNames(const fs::path& root) {
  Names names;
  for (const char* top : {"engrave", "materials_db", "proto", "services"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const bool is_header = entry.path().extension() == ".h";
      if (!is_header && entry.path().extension() != ".cc") continue;
      AddNames(WithoutText(TextOfFile(entry.path())),
               is_header ? entry.path().lexically_relative(root).string() : "", names);
    }
  }
  std::erase_if(names.declared,
                [&](const auto& name) { return names.used.contains(name.first); });
  return names.declared;
}

std::vector<std::string> UnreachedFunctions(const fs::path& root) {
  std::vector<std::string> sentences;
  const auto unreached = UnreachedNames(root);
  for (const auto& [name, header] : unreached) {
    if (!kStay.contains(name))
      sentences.push_back(header + ": no program uses " + name +
                          "; remove it, or move it to the tests that do");
  }
  for (const auto& [name, why] : kStay) {
    if (!unreached.contains(name))
      sentences.push_back("tests/walls/unreached.cc: " + name + " (" + why +
                          ") is gone or reached; remove it from kStay");
  }
  return sentences;
}

}  // namespace intaglio::walls
