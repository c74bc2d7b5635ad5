#include "services/cli/misspelt.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

namespace intaglio::cli {
namespace {

constexpr std::size_t kMostEdits = 2;

// Optimal string alignment (Damerau 1964, restricted).
std::size_t EditsBetween(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1,
                                          std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t wrong = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + wrong});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

// The command that was being read: the innermost that was given.
const CLI::App& InnermostOf(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : InnermostOf(*given.back());
}

std::vector<std::string> OptionsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> CommandsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::string PathOf(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : PathOf(*parent) + " " + app.get_name();
}

}  // namespace

std::optional<std::string> NearestWord(const std::string& word,
                                       const std::vector<std::string>& known) {
  std::optional<std::string> nearest;
  std::size_t least = std::min(kMostEdits + 1, (word.size() + 1) / 2);
  for (const std::string& candidate : known) {
    const std::size_t edits = EditsBetween(word, candidate);
    if (edits >= least) continue;
    least = edits;
    nearest = candidate;
  }
  return nearest;
}

std::string TextOfUnknownWords(const CLI::App& app) {
  const CLI::App& innermost = InnermostOf(app);
  const std::vector<std::string> words = app.remaining(true);
  if (words.empty()) return "";
  const std::string word = words.front().substr(0, words.front().find('='));
  const bool option = word.starts_with("-");
  const auto known = option ? OptionsOf(innermost) : CommandsOf(innermost);
  const auto meant = NearestWord(word, known);
  const std::string path = PathOf(innermost);
  const std::string what = option          ? "has no option"
                           : known.empty() ? "has no use for"
                                           : "has no command";
  return fmt::format("{} {} '{}'{}; {} --help tells what there is", path, what, word,
                     meant ? fmt::format(", did you mean {}?", *meant) : "", path);
}

}  // namespace intaglio::cli
