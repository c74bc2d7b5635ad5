#include "tests/walls/includes.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <sstream>
#include <string_view>

#include "tests/walls/tree_files.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;

struct Row {
  std::string_view header;
  std::vector<std::string_view> names;
};

const std::vector<Row>& Rows() {
  static const std::vector<Row> kRows = {
      {"Eigen/Cholesky", {".ldlt(", ".llt("}},
      {"Eigen/Geometry",
       {"Eigen::AlignedBox", "Eigen::AngleAxis", "Eigen::Quaternion", "Eigen::Rotation2D",
        "Eigen::Translation", "Eigen::Isometry", "Eigen::Affine", ".cross(",
        ".unitOrthogonal("}},
      {"chrono", {"std::chrono::"}},
      {"filesystem", {"std::filesystem"}},
      {"fmt/format.h", {"fmt::format("}},
      {"functional", {"std::function<"}},
      {"map", {"std::map<", "std::multimap<"}},
      {"memory",
       {"std::unique_ptr<", "std::shared_ptr<", "std::make_unique<",
        "std::make_shared<"}},
      {"optional", {"std::optional<"}},
      {"span", {"std::span<", "std::span("}},
      {"string", {"std::string("}},
      {"vector", {"std::vector<"}},
  };
  return kRows;
}

/// Headers that have all of another one, as their documentation says.
const std::multimap<std::string_view, std::string_view> kWhole = {
    {"Eigen/Dense", "Eigen/Cholesky"},
    {"Eigen/Dense", "Eigen/Geometry"},
    {"fmt/chrono.h", "fmt/format.h"},
    {"fmt/ranges.h", "fmt/format.h"}};

/// The line without what stands in quotes and behind "//".
std::string CodeOf(const std::string& line) {
  std::string code;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quoted && line[i] == '\\') {
      ++i;
    } else if (line[i] == '"') {
      quoted = !quoted;
    } else if (!quoted) {
      if (line.compare(i, 2, "//") == 0) break;
      code += line[i];
    }
  }
  return code;
}

struct Source {
  std::set<std::string> includes;
  std::set<std::string_view> used;  ///< headers whose names are used
};

Source Scan(const fs::path& file) {
  Source source;
  std::istringstream text(TextOfFile(file));
  for (std::string line; std::getline(text, line);) {
    if (const std::string name = IncludedBy(line); !name.empty()) {
      source.includes.insert(name);
      const auto [begin, end] = kWhole.equal_range(name);
      for (auto whole = begin; whole != end; ++whole)
        source.includes.insert(std::string(whole->second));
      continue;
    }
    const std::string code = CodeOf(line);
    for (const Row& row : Rows()) {
      const auto is_used = [&](std::string_view name) {
        return code.find(name) != std::string::npos;
      };
      if (std::ranges::any_of(row.names, is_used)) source.used.insert(row.header);
    }
  }
  return source;
}

using Sources = std::map<std::string, Source>;

/// What the file includes, by itself and by headers of this tree.
std::set<std::string> AllIncludes(const Sources& sources, const std::string& file) {
  std::set<std::string> all;
  std::vector<std::string> open = {file};
  while (!open.empty()) {
    const auto found = sources.find(open.back());
    open.pop_back();
    if (found == sources.end()) continue;
    for (const std::string& name : found->second.includes) {
      if (all.insert(name).second) open.push_back(name);
    }
  }
  return all;
}

}  // namespace

std::vector<std::string> MissingIncludes(const fs::path& root) {
  Sources sources;
  for (const char* top : {"engrave", "materials_db", "services", "tests"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".cc")
        sources[entry.path().lexically_relative(root).string()] = Scan(entry.path());
    }
  }
  std::vector<std::string> missing;
  for (const auto& [file, source] : sources) {
    if (source.used.empty()) continue;
    const std::set<std::string> all = AllIncludes(sources, file);
    for (const std::string_view header : source.used) {
      if (!all.contains(std::string(header)))
        missing.push_back(file + ": uses names of <" + std::string(header) +
                          ">, include it");
    }
  }
  return missing;
}

}  // namespace intaglio::walls
