#include "tests/walls/language.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <set>

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;

const std::set<std::string, std::less<>> kRetired = {
    "tell",   "tells", "told",    "telling",   "hear",       "hears", "heard",
    "say",    "says",  "said",    "saying",    "stand",      "stood", "stands",
    "look",   "looks", "looked",  "looking",   "mend",       "mends", "mended",
    "papers", "doubt", "doubts",  "bystander", "bystanders", "word",  "words",
    "least",  "most",  "hearing", "standing",  "doubted"};
const std::set<std::string, std::less<>> kRetiredButOfVertices = {
    "weld", "welds", "welded", "welding", "welder"};
// A word of a text that is read.
const std::set<std::string, std::less<>> kTokensOfText = {"word", "words", "word_",
                                                          "words_"};

std::vector<std::string> PartsOf(std::string_view identifier) {
  std::vector<std::string> parts;
  bool begins = true;
  for (std::size_t i = 0; i < identifier.size(); ++i) {
    const char c = identifier[i];
    const bool letter = std::isalpha(static_cast<unsigned char>(c)) != 0;
    const bool upper = std::isupper(static_cast<unsigned char>(c)) != 0;
    if (letter && (begins || upper)) parts.emplace_back();
    if (letter)
      parts.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    begins = !letter;
  }
  return parts;
}

/// Just behind a comment or a literal that begins at `at`; `at` when none does.
std::size_t BehindText(std::string_view source, std::size_t at) {
  const auto behind = [&](std::string_view end, std::size_t from) {
    const auto found = source.find(end, from);
    return found == std::string_view::npos ? source.size() : found + end.size();
  };
  const std::string_view rest = source.substr(at);
  if (rest.starts_with("//")) return behind("\n", at);
  if (rest.starts_with("/*")) return behind("*/", at + 2);
  if (rest.starts_with("R\"")) {
    const auto open = rest.find('(');
    if (open == std::string_view::npos) return source.size();
    return behind(")" + std::string(rest.substr(2, open - 2)) + "\"", at + open);
  }
  const char quote = rest.front();
  if (quote != '"' && quote != '\'') return at;
  // 1'000: a separator of digits.
  if (quote == '\'' && at > 0 &&
      std::isxdigit(static_cast<unsigned char>(source[at - 1])) != 0)
    return at + 1;
  for (std::size_t i = at + 1; i < source.size(); ++i) {
    if (source[i] == '\\')
      ++i;
    else if (source[i] == quote || source[i] == '\n')
      return i + 1;
  }
  return source.size();
}

/// In the order of their paths.
std::vector<fs::path> FilesBelow(const fs::path& root) {
  std::vector<fs::path> files;
  for (const char* top :
       {"engrave", "idl", "materials_db", "proto", "services", "tests"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".cc" || extension == ".idl" ||
          extension == ".proto")
        files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Whose comments are not all sentences yet.
constexpr std::string_view kFoldersWithOf[] = {"engrave/",      "idl/",
                                               "proto/",        "services/drivers/",
                                               "services/job/", "services/platform/"};

/// Whether a comment of this line begins with "Of".
bool BeginsWithOf(std::string_view line) {
  const auto slashes = line.find("//");
  if (slashes == std::string_view::npos) return false;
  const auto text = line.find_first_not_of("/<", slashes);
  return text != std::string_view::npos && line.substr(text).starts_with(" Of ");
}

}  // namespace

bool IsOfName(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

std::string RetiredPartOf(std::string_view identifier, std::string_view path) {
  const bool of_vertices = path.find("engrave/mesh/") != std::string_view::npos;
  if (kTokensOfText.contains(identifier)) return {};
  const std::vector<std::string> parts = PartsOf(identifier);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!of_vertices && kRetiredButOfVertices.contains(parts[i])) return parts[i];
    if (!kRetired.contains(parts[i])) continue;
    // "At least" and "at most" are plain; look-ahead is the field's term.
    const bool bound = parts[i] == "least" || parts[i] == "most";
    if (bound && i > 0 && parts[i - 1] == "at") continue;
    if (parts[i] == "look" && i + 1 < parts.size() && parts[i + 1] == "ahead") continue;
    return parts[i];
  }
  return {};
}

std::string WithoutText(std::string_view source) {
  std::string code(source);
  for (std::size_t at = 0; at < source.size(); ++at) {
    const auto behind = BehindText(source, at);
    if (behind == at) continue;
    for (; at < behind; ++at) {
      if (code[at] != '\n') code[at] = ' ';
    }
    --at;
  }
  return code;
}

std::vector<std::string> IdentifiersOf(std::string_view source) {
  const std::string code = WithoutText(source);
  std::vector<std::string> identifiers;
  for (std::size_t at = 0; at < code.size();) {
    auto end = at;
    while (end < code.size() && IsOfName(code[end])) ++end;
    if (end > at && std::isdigit(static_cast<unsigned char>(code[at])) == 0)
      identifiers.push_back(code.substr(at, end - at));
    at = std::max(end, at + 1);
  }
  return identifiers;
}

std::vector<std::string> RetiredNames(const fs::path& root) {
  std::set<std::string> found;
  std::vector<std::string> sentences;
  for (const fs::path& file : FilesBelow(root)) {
    const std::string path = file.lexically_relative(root).string();
    std::ifstream in(file);
    const std::string source{std::istreambuf_iterator<char>(in), {}};
    for (const std::string& identifier : IdentifiersOf(source)) {
      const std::string word = RetiredPartOf(identifier, path);
      if (word.empty() || !found.insert(identifier).second) continue;
      sentences.push_back(path + ": " + identifier + " has the retired word '" + word +
                          "'; docs/glossary.md has what replaced it");
    }
  }
  return sentences;
}

std::vector<std::string> CommentsThatBeginWithOf(const fs::path& root) {
  std::vector<std::string> sentences;
  for (const fs::path& file : FilesBelow(root)) {
    const std::string path = file.lexically_relative(root).string();
    if (std::ranges::any_of(kFoldersWithOf, [&](std::string_view folder) {
          return path.starts_with(folder);
        }))
      continue;
    std::ifstream in(file);
    int number = 1;
    for (std::string line; std::getline(in, line); ++number) {
      if (!BeginsWithOf(line)) continue;
      sentences.push_back(path + ":" + std::to_string(number) +
                          ": a comment begins with 'Of'; give it a subject and a verb");
    }
  }
  return sentences;
}

}  // namespace intaglio::walls
