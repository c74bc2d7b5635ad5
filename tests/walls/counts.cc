#include "tests/walls/counts.h"

#include <algorithm>
#include <regex>
#include <set>

#include "tests/walls/tree_files.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;

/// What messages and statistics count. Units are none of it: bytes, degrees, pixels.
const std::regex& CountBeforeNoun() {
  static const std::regex count(
      R"(\{[a-z0-9_]*(?::[d>0-9]*)?\} (?:(?!(?:and|by|for|in|of|on|or|to|with) )[a-z-]*[a-rt-z] )?)"
      "(?:attempts|axes|batches|blocks|channels|chunks|codes|columns|contours|copies|"
      "cracks|days|edges|elements|entities|faces|fields|files|glasses|holes|jobs|layers|"
      "lines|marks|messages|models|moves|nets|pairs|parts|passes|patches|pieces|planes|"
      "points|pulses|rays|records|rows|runs|samples|segments|services|sheets|slices|"
      "stations|steps|submissions|tabs|texts|ticks|times|tools|triangles|turns|vertices|"
      "warnings|wavelengths)\\b(?!/)");
  return count;
}

struct Exception {
  std::string_view path;
  std::string_view count;
  std::string_view reason;
};

constexpr Exception kExceptions[] = {
    {"engrave/galvo/grid_sense.cc", "{} runs", "a verb: an axis runs against another"},
    {"engrave/post/lathe_reach.cc", "{} passes", "a verb: a tool passes an axis"},
    {"engrave/render/web/mark_close_up.cc", "{} times", "a magnification"},
    {"engrave/render/web/mark_overview.cc", "{} times", "a magnification"},
    {"services/cli/schemas/json_schema.cc", "{} times", "a factor of another field"},
    {"services/client/shop/shop_status.cc", "{} runs", "a verb: no service of a role"},
    {"services/job/course/course_marks.cc", "{} tools", "two at least"},
    {"services/job/methods/drawing_methods.cc", "{} layers", "two at least"},
    {"services/job/models/reading_process.cc", "{} files", "the name of a format"},
    {"services/job_service/submission_reader.cc", "{} earlier submissions",
     "a constant above one"},
    {"services/replayer/rehearsal.cc", "{} samples", "a text of the recording"},
    {"services/virtual_engraver/truth/truth_check.cc", "{} stations", "above a limit"}};

bool Contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

/// A count that is compared with a limit, or is one, is above one.
bool IsComparedWithLimit(std::string_view before, std::string_view behind) {
  constexpr std::string_view kBefore[] = {"than ", "than the ", "at most ", "to ",
                                          "the "};
  constexpr std::string_view kBehind[] = {"more than", "than ",      "limit",
                                          "too many",  "exceeds",    ", above {}",
                                          " allowed",  " is at most"};
  if (Contains(before, "more than")) return true;
  return std::ranges::any_of(kBefore, [&](auto end) { return before.ends_with(end); }) ||
         std::ranges::any_of(kBehind, [&](auto part) { return Contains(behind, part); });
}

/// The literal that begins at a quote, with those that follow it at once.
struct Literal {
  std::string text;
  std::size_t behind = 0;
};

Literal LiteralAt(std::string_view source, std::size_t quote) {
  Literal literal;
  std::size_t at = quote;
  while (at < source.size() && source[at] == '"') {
    for (++at; at < source.size() && source[at] != '"' && source[at] != '\n'; ++at) {
      if (source[at] == '\\' && at + 1 < source.size()) literal.text += source[at++];
      literal.text += source[at];
    }
    literal.behind = std::min(at + 1, source.size());
    at = source.find_first_not_of(" \n", literal.behind);
  }
  return literal;
}

/// Where the comment or the character that begins here ends; `at` when none does.
std::size_t BehindComment(std::string_view source, std::size_t at) {
  const std::string_view rest = source.substr(at);
  if (rest.starts_with("//")) return std::min(source.find('\n', at), source.size());
  if (rest.starts_with("'\"'")) return at + 3;
  return at;
}

/// The code of the statement that a literal at this place belongs to.
std::string_view StatementBefore(std::string_view source, std::size_t quote) {
  const auto begin = source.find_last_of(";{}", quote);
  return source.substr(begin == std::string_view::npos ? 0 : begin,
                       quote - (begin == std::string_view::npos ? 0 : begin));
}

void AddCounts(const std::string& text, std::size_t line,
               std::vector<std::string>& counts) {
  const std::sregex_iterator end;
  for (std::sregex_iterator at(text.begin(), text.end(), CountBeforeNoun()); at != end;
       ++at) {
    const std::string before = text.substr(0, static_cast<std::size_t>(at->position()));
    if (before.ends_with("{} x ") || before.ends_with("{0} x ")) continue;
    if (IsComparedWithLimit(before, at->suffix().str())) continue;
    counts.push_back(std::to_string(line) + ": " + at->str());
  }
}

}  // namespace

std::vector<std::string> BareCounts(std::string_view source) {
  std::vector<std::string> counts;
  for (std::size_t at = 0; at < source.size(); ++at) {
    if (const auto behind = BehindComment(source, at); behind != at) {
      at = behind - 1;
      continue;
    }
    if (source[at] != '"') continue;
    const Literal literal = LiteralAt(source, at);
    if (!Contains(StatementBefore(source, at), "Require(")) {
      const auto line = 1 + std::ranges::count(source.substr(0, at), '\n');
      AddCounts(literal.text, static_cast<std::size_t>(line), counts);
    }
    at = literal.behind - 1;
  }
  return counts;
}

std::vector<std::string> BareCountsBelow(const fs::path& root) {
  std::vector<std::string> sentences;
  std::set<const Exception*> needed;
  for (const char* top : {"engrave", "materials_db", "services"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (entry.path().extension() != ".h" && entry.path().extension() != ".cc") continue;
      const std::string path = entry.path().lexically_relative(root).string();
      for (const std::string& count : BareCounts(TextOfFile(entry.path()))) {
        const auto* exception =
            std::ranges::find_if(kExceptions, [&](const Exception& e) {
              return e.path == path && count.ends_with(e.count);
            });
        if (exception != std::end(kExceptions))
          needed.insert(exception);
        else
          sentences.push_back(path + ":" + count +
                              ": of one it is wrong; use Counted of "
                              "engrave/core/counted.h");
      }
    }
  }
  for (const Exception& exception : kExceptions) {
    if (needed.contains(&exception) || !fs::exists(root / exception.path)) continue;
    sentences.push_back(std::string(exception.path) + ": the exception '" +
                        std::string(exception.count) + "' is not needed; remove it");
  }
  std::ranges::sort(sentences);
  return sentences;
}

}  // namespace intaglio::walls
