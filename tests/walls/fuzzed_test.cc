#include "tests/walls/fuzzed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

TEST(Fuzzed, EveryParserOfThisTree) {
  EXPECT_THAT(UnfuzzedParsers(INTAGLIO_SOURCE_DIR), IsEmpty());
}

TEST(Fuzzed, SeesTheParsersOfAHeader) {
  const fs::path root = test::FreshFolder();
  fs::create_directories(root / "engrave/core");
  std::ofstream(root / "engrave/core/a.h")
      << "Result<A> ParseA(std::string_view text);\n"
         "Result<std::vector<A>> ReadAs(std::span<const std::byte> bytes,\n"
         "                              int limit);\n"
         "std::optional<A> DecodeAsALongName(\n    std::string_view text);\n"
         "// Result<A> ParseInAComment(std::string_view text);\n"
         "Result<A> ReadAFile(const std::filesystem::path& file);\n"
         "std::string ReadIt(std::string_view text);\n";
  EXPECT_THAT(DeclaredParsers(root),
              ElementsAre(Pair("DecodeAsALongName", "engrave/core/a.h"),
                          Pair("ParseA", "engrave/core/a.h"),
                          Pair("ReadAs", "engrave/core/a.h")));
}

}  // namespace
}  // namespace intaglio::walls
