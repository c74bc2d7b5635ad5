// Every command line `intaglio ...` in a code block of README.md, of docs/ and of the
// examples is one that the program understands.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "services/cli/intaglio_program.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct DocumentedCommand {
  std::string where;  // file:line
  std::vector<std::string> words;
};

/// The words of the commands of a line, as a shell divides them; a comment, and what is
/// redirected, is left out.
std::vector<std::vector<std::string>> CommandsIn(const std::string& line) {
  std::vector<std::vector<std::string>> commands(1);
  std::string word;
  bool in_argument = false;
  char quote = 0;
  const auto end_argument = [&] {
    if (in_argument) commands.back().push_back(word);
    word.clear();
    in_argument = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0) {
      if (c == quote) {
        quote = 0;
      } else {
        word += c;
      }
    } else if (c == '\'' || c == '"') {
      quote = c;
      in_argument = true;
    } else if (c == '#' && !in_argument) {
      break;
    } else if (c == ' ') {
      end_argument();
    } else if (c == ';' || c == '|' || c == '&') {
      end_argument();
      commands.emplace_back();
    } else if (c == '>' || c == '<') {
      end_argument();
      commands.emplace_back();  // the file, which is no command of ours
    } else if (c == '\\' && i + 1 < line.size()) {
      word += line[++i];
      in_argument = true;
    } else {
      word += c;
      in_argument = true;
    }
  }
  end_argument();
  return commands;
}

/// Without what stands before a command: sudo, NAME=VALUE.
std::vector<std::string> WithoutPrefix(std::vector<std::string> words) {
  while (!words.empty() && (words.front() == "sudo" || words.front() == "time" ||
                            (words.front().find('=') != std::string::npos &&
                             words.front().front() != '-'))) {
    words.erase(words.begin());
  }
  return words;
}

void Collect(const fs::path& file, bool whole_file, std::vector<DocumentedCommand>& all) {
  std::ifstream in(file);
  std::string line, joined;
  bool in_block = whole_file;
  for (int number = 1; std::getline(in, line); ++number) {
    const auto text = line.find_first_not_of(' ');
    if (text != std::string::npos && line.compare(text, 3, "```") == 0) {
      in_block = !in_block;
      continue;
    }
    if (!in_block) continue;
    joined += line;
    if (joined.ends_with('\\')) {
      joined.pop_back();
      continue;
    }
    for (const auto& words : CommandsIn(std::exchange(joined, ""))) {
      const auto command = WithoutPrefix(words);
      if (command.size() < 2 || command.front() != "intaglio") continue;
      all.push_back({file.filename().string() + ":" + std::to_string(number),
                     {command.begin() + 1, command.end()}});
    }
  }
}

std::vector<DocumentedCommand> AllDocumented() {
  const fs::path root = INTAGLIO_SOURCE_DIR;
  std::vector<DocumentedCommand> all;
  Collect(root / "README.md", false, all);
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") Collect(entry.path(), false, all);
  }
  return all;
}

TEST(DocumentedCommands, AreDividedAsAShellDoes) {
  using ::testing::ElementsAre;
  EXPECT_THAT(CommandsIn("a 'b c' \"d\"  # e"),
              ElementsAre(ElementsAre("a", "b c", "d")));
  EXPECT_THAT(CommandsIn("a b; c | d"),
              ElementsAre(ElementsAre("a", "b"), ElementsAre("c"), ElementsAre("d")));
  EXPECT_THAT(CommandsIn("a > f"), ElementsAre(ElementsAre("a"), ElementsAre("f")));
}

TEST(DocumentedCommands, AreUnderstood) {
  const auto all = AllDocumented();
  EXPECT_GT(all.size(), 80u);
  for (const DocumentedCommand& command : all) {
    const Status parsed = IntaglioProgram()->Parse(command.words);
    std::string line = "intaglio";
    for (const std::string& word : command.words) line += " " + word;
    EXPECT_TRUE(parsed) << command.where << ": " << line << "\n"
                        << (parsed ? "" : parsed.error().message);
  }
}

}  // namespace
}  // namespace intaglio::cli
