#include "tests/walls/fuzzed.h"

#include <regex>
#include <set>

#include "tests/walls/language.h"
#include "tests/walls/tree_files.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;

/// Parsers that a fuzzed parser calls, or that do nothing but call it, with its name.
const std::map<std::string, std::string> kCalledBy = {
    {"ParseBmp", "ParseImage"},
    {"ParseCoordinateLines", "ParseXyz"},
    {"ParseFinite", "ReadSvg"},
    {"ParseGerberAperture", "ReadGerber"},
    {"ParseGerberFormat", "ReadGerber"},
    {"ParseGerberRepeat", "ReadGerber"},
    {"ParseGerberUnit", "ReadGerber"},
    {"ParseJpeg", "ParseImage"},
    {"ParseNumber", "ParseXyz"},
    {"ParseNumbers", "ImportRii"},
    {"ParsePcx", "ParseImage"},
    {"ParsePlyHeader", "ParsePly"},
    {"ParsePng", "ParseImage"},
    {"ParseTiff", "ParseImage"},
    {"ParsePoints", "ParsePly"},
    {"ParseSvgLength", "ReadSvg"},
    {"ParseSvgOrigin", "ReadSvg"},
    {"ParseSvgPath", "ReadSvg"},
    {"ParseSvgTransform", "ReadSvg"},
    {"ParseSvgViewBox", "ReadSvg"},
    {"ParseTemplate", "ParseMillTemplate"},
    {"ReadObj", "ImportMeshFromMemory"},
    {"ReadOwnFormat", "ImportMeshFromMemory"},
    {"ReadPly", "ImportMeshFromMemory"},
    {"ReadStl", "ImportMeshFromMemory"},
    {"ReadThreeMf", "ImportMeshFromMemory"}};

/// Parsers without a target, and why.
const std::map<std::string, std::string> kWithout = {
    {"ParseFault", "typed: an option of virtual-engraver"},
    {"ParseStations", "typed: an option of the command line"}};

/// The names in all files of a folder.
std::set<std::string> NamesIn(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".cc" && entry.path().extension() != ".h") continue;
    const std::string code = WithoutText(TextOfFile(entry.path()));
    for (std::size_t at = 0; at < code.size();) {
      auto end = at;
      while (end < code.size() && IsOfName(code[end])) ++end;
      if (end > at) names.insert(code.substr(at, end - at));
      at = std::max(end, at + 1);
    }
  }
  return names;
}

}  // namespace

std::map<std::string, std::string> DeclaredParsers(const fs::path& root) {
  static const std::regex kParser(
      R"((?:Result|optional)<[^;{}()]*>\s+((?:Parse|Read|Decode|Import|Unpack)\w+)\()"
      R"(\s*(?:std::string_view|const std::string& text|std::span<const std::byte>|)"
      R"(ByteView|ByteReader&))");
  std::map<std::string, std::string> parsers;
  for (const char* top : {"engrave", "materials_db", "proto", "services"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (entry.path().extension() != ".h") continue;
      const std::string code = WithoutText(TextOfFile(entry.path()));
      for (std::sregex_iterator found(code.begin(), code.end(), kParser), end;
           found != end; ++found)
        parsers.emplace((*found)[1], entry.path().lexically_relative(root).string());
    }
  }
  return parsers;
}

std::vector<std::string> UnfuzzedParsers(const fs::path& root) {
  const auto parsers = DeclaredParsers(root);
  const std::set<std::string> called = NamesIn(root / "tests/fuzz");
  std::vector<std::string> sentences;
  for (const auto& [name, header] : parsers) {
    if (!called.contains(name) && !kCalledBy.contains(name) && !kWithout.contains(name))
      sentences.push_back(header + ": no fuzz target calls " + name +
                          "; add one to tests/fuzz, or name the parser that calls it in "
                          "tests/walls/fuzzed.cc");
  }
  const auto check = [&](const std::string& name, bool is_caller_fuzzed) {
    if (!parsers.contains(name) || called.contains(name) || !is_caller_fuzzed)
      sentences.push_back(
          "tests/walls/fuzzed.cc: " + name +
          " is gone, has a target, or its caller has none; correct its row");
  };
  for (const auto& [name, caller] : kCalledBy) check(name, called.contains(caller));
  for (const auto& [name, why] : kWithout) check(name, true);
  return sentences;
}

}  // namespace intaglio::walls
