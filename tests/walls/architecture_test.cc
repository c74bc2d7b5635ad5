// docs/architecture.md against the tree: the files and folders that it names exist, and
// so do the functions and classes of its trunk.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "tests/walls/tree_files.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;

/// What stands between ` and ` and matches the pattern as a whole.
std::set<std::string> Quoted(const std::string& text, const std::regex& pattern) {
  std::set<std::string> found;
  const std::regex quoted("`([^`\n]+)`");
  for (auto it = std::sregex_iterator(text.begin(), text.end(), quoted);
       it != std::sregex_iterator(); ++it) {
    if (std::regex_match((*it)[1].str(), pattern)) found.insert((*it)[1]);
  }
  return found;
}

bool IsInTree(const std::string& name) {
  for (const char* extension : {"", ".h", ".cc", ".proto", ".idl", "_test.cc"}) {
    if (fs::exists(kRoot / (name + extension))) return true;
  }
  return false;
}

TEST(Architecture, NamesFilesThatExist) {
  const auto names = Quoted(
      TextOfFile(kRoot / "docs/architecture.md"),
      std::regex("(engrave|services|idl|proto|tests|deploy|materials_db)/[a-z0-9_/.]+"));
  EXPECT_GT(names.size(), 100u);
  for (const std::string& name : names) EXPECT_TRUE(IsInTree(name)) << name;
}

bool HasSources(const fs::path& folder) {
  return std::ranges::any_of(fs::directory_iterator(folder), [](const auto& entry) {
    return entry.path().extension() == ".h" || entry.path().extension() == ".cc";
  });
}

// By its own name with a slash: the tree writes some beside the folder that they are in.
TEST(Architecture, ItsSourceTreeHasEveryFolder) {
  const std::string document = TextOfFile(kRoot / "docs/architecture.md");
  const auto begin = document.find("## Source tree");
  const auto tree = document.substr(begin, document.find("\n## ", begin) - begin);
  int count = 0;
  for (const char* top : {"engrave", "services"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / top)) {
      if (!entry.is_directory() || !HasSources(entry.path())) continue;
      ++count;
      const std::regex name("(^|[^a-z_])" + entry.path().filename().string() + "/");
      EXPECT_TRUE(std::regex_search(tree, name)) << entry.path();
    }
  }
  EXPECT_GT(count, 80);
}

TEST(Architecture, NamesFunctionsOfTheTrunkThatExist) {
  const std::string document = TextOfFile(kRoot / "docs/architecture.md");
  const auto begin = document.find("## The trunk"), end = document.find("## Source tree");
  ASSERT_LT(begin, end);
  const auto names = Quoted(document.substr(begin, end - begin),
                            std::regex("[A-Z][A-Za-z]+(::[A-Z][A-Za-z]+)?"));
  EXPECT_GT(names.size(), 20u);
  std::string headers;
  for (const char* folder : {"services", "engrave", "proto"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const auto extension = entry.path().extension();
      if (extension == ".h" || extension == ".proto") headers += TextOfFile(entry.path());
    }
  }
  for (const std::string& name : names) {
    const auto colons = name.find("::");
    const std::string last = colons == std::string::npos ? name : name.substr(colons + 2);
    EXPECT_NE(headers.find(last), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace intaglio::walls
