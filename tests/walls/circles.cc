#include "tests/walls/circles.h"

#include <fstream>
#include <map>
#include <set>

#include "tests/walls/tree_files.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;

struct Include {
  std::string file, included;
};
/// The includes by the including folder and the included one.
using Arrows = std::map<std::string, std::map<std::string, Include>>;

std::string ParentOf(const std::string& path) { return path.substr(0, path.rfind('/')); }

void AddArrows(const fs::path& root, const fs::path& file, Arrows& arrows) {
  const std::string path = file.lexically_relative(root).string();
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::string included = IncludedBy(line);
    if (included.empty() || ParentOf(included) == ParentOf(path)) continue;
    Include& first = arrows[ParentOf(path)][ParentOf(included)];
    if (first.file.empty() || path < first.file) first = {path, included};
  }
}

Arrows ArrowsIn(const fs::path& root) {
  Arrows arrows;
  for (const char* top : {"engrave", "materials_db", "services"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".cc") AddArrows(root, entry.path(), arrows);
    }
  }
  return arrows;
}

std::set<std::string> ReachedFrom(const std::string& folder, const Arrows& arrows) {
  std::set<std::string> reached;
  std::vector<std::string> open = {folder};
  while (!open.empty()) {
    const auto found = arrows.find(open.back());
    open.pop_back();
    if (found == arrows.end()) continue;
    for (const auto& [next, include] : found->second) {
      if (reached.insert(next).second) open.push_back(next);
    }
  }
  return reached;
}

}  // namespace

std::vector<std::string> FoldersInCircles(const fs::path& root) {
  const Arrows arrows = ArrowsIn(root);
  std::vector<std::string> sentences;
  for (const auto& [folder, below] : arrows) {
    for (const auto& [other, include] : below) {
      if (!ReachedFrom(other, arrows).contains(folder)) continue;
      sentences.push_back(include.file + ": includes " + include.included + ", but " +
                          other + " leads back to " + folder);
    }
  }
  return sentences;
}

}  // namespace intaglio::walls
