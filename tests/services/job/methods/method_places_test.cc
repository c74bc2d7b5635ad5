// How many places a method touches: its own files, its row of the table, its message in
// the schema. No other source of the product names one.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const fs::path kRoot = INTAGLIO_SOURCE_DIR;

std::string TextOf(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Reads the product's C++ below a folder, without its comments, by its path in the tree.
std::map<std::string, std::string> SourcesBelow(const std::string& folder) {
  std::map<std::string, std::string> sources;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
    const auto ending = entry.path().extension();
    if (ending != ".h" && ending != ".cc") continue;
    std::string& text = sources[entry.path().lexically_relative(kRoot).string()];
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);) {
      text += line.substr(0, line.find("//")) + "\n";
    }
  }
  return sources;
}

/// What names a method in C++: its message, its accessors in a model and a
/// discretization, its number, its name as a text; the rows themselves have texts that
/// name fields.
std::vector<std::string> NamesOf(const Method& method, const std::string& path) {
  const std::string& name = method.name();
  std::string camel;
  bool begins = true;
  for (const char c : name) {
    if (c != '_') {
      camel +=
          begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    }
    begins = c == '_';
  }
  std::vector<std::string> names = {method.message().name(), "Model::k" + camel,
                                    "Discretization::k" + camel};
  for (const char* what : {"has_", "mutable_", "clear_", "release_", "set_allocated_"}) {
    names.push_back(what + name + "(");
  }
  for (const char* holder : {"model.", "model().", "models(i).", "models(0).",
                             "discretization.", "discretization()."}) {
    names.push_back(holder + name + "()");
  }
  if (!path.starts_with("services/job/methods/")) names.push_back('"' + name + '"');
  return names;
}

bool Names(const Method& method, const std::string& path, const std::string& text) {
  const auto names = NamesOf(method, path);
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return text.find(name) != std::string::npos;
  });
}

std::size_t CountOf(const std::string& word, const std::string& text) {
  const std::regex whole("\\b" + word + "\\b");
  return static_cast<std::size_t>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), whole), {}));
}

TEST(MethodPlaces, AreItsRowAndItsMaker) {
  const auto sources = SourcesBelow("services");
  ASSERT_GT(sources.size(), 100u);
  for (const Method& method : Methods()) {
    std::vector<std::string> files;
    for (const auto& [path, text] : sources) {
      if (Names(method, path, text)) files.push_back(path);
    }
    EXPECT_THAT(
        files,
        ElementsAre(testing::MatchesRegex("services/job/methods/[a-z]+_makers.cc"),
                    testing::MatchesRegex("services/job/methods/[a-z]+_methods.cc")))
        << method.name();
  }
}

// A list of them in a help or a message would not be made from the table.
TEST(MethodPlaces, AreNoTextThatListsThem) {
  static const std::regex kLiteral(R"lit("(?:[^"\\\n]|\\.)*")lit");
  std::vector<std::string> lists;
  for (const auto& [path, text] : SourcesBelow("services")) {
    if (path.starts_with("services/job/methods/")) continue;
    for (std::sregex_iterator at(text.begin(), text.end(), kLiteral), end; at != end;
         ++at) {
      std::size_t named = 0;
      for (const Method& method : Methods()) {
        named += CountOf(method.name(), at->str()) > 0 ? 1 : 0;
      }
      if (named >= 2) lists.push_back(path + ": " + at->str());
    }
  }
  EXPECT_THAT(lists, IsEmpty());
}

// The headers of the algorithms are included by their own room and by the rows.
TEST(MethodPlaces, AreTheirOwnFilesInTheRoomOfTheirKind) {
  static const std::regex kIncluded(
      R"(#include "engrave/discretize/(mesh|drawing|picture)/(\w+)\.h")");
  const std::set<std::string> rooms = {"engrave/discretize/mesh/",
                                       "engrave/discretize/drawing/",
                                       "engrave/discretize/picture/"};
  for (const auto& top : {"engrave", "services"}) {
    for (const auto& [path, text] : SourcesBelow(top)) {
      if (path.starts_with("services/job/methods/")) continue;
      const std::string room = path.substr(0, path.rfind('/') + 1);
      if (rooms.contains(room)) continue;
      for (std::sregex_iterator at(text.begin(), text.end(), kIncluded), end; at != end;
           ++at) {
        EXPECT_EQ(FindMethod((*at)[2].str()), nullptr)
            << path << " includes " << at->str();
      }
    }
  }
}

// Its message, and a line of each choice that it belongs to.
TEST(MethodPlaces, AreItsMessageAndItsChoicesInTheSchema) {
  std::string schemas;
  for (const auto& entry : fs::directory_iterator(kRoot / "proto")) {
    if (entry.path().extension() == ".proto") schemas += TextOf(entry.path());
  }
  for (const Method& method : Methods()) {
    EXPECT_EQ(CountOf(method.message().name(), schemas),
              FieldInDiscretization(method) == nullptr ? 2u : 3u)
        << method.name();
  }
}

}  // namespace
}  // namespace intaglio
