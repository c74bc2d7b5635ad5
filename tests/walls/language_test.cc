#include "tests/walls/language.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Language, HoldsInThisTree) {
  EXPECT_THAT(RetiredNames(INTAGLIO_SOURCE_DIR), IsEmpty());
}

TEST(Language, PartsOfNamesAreChecked) {
  for (const auto& [name, word] :
       {std::pair<const char*, const char*>{"kMostSteps", "most"},
        {"least_spacing_mm", "least"},
        {"TellSession", "tell"},
        {"told_", "told"},
        {"IsToldOnce", "told"},
        {"CellWords", "words"},
        {"PointsStandHere", "stand"},
        {"WeldPoint", "weld"}}) {
    EXPECT_EQ(RetiredPartOf(name, "engrave/sort/a.cc"), word) << name;
  }
  for (const char* name :
       {"almost", "kMaxSteps", "standard", "LookAhead", "look_ahead_points", "AtLeast",
        "lookup", "words", "word_", "essay", "hearth", "mostly"}) {
    EXPECT_EQ(RetiredPartOf(name, "engrave/sort/a.cc"), "") << name;
  }
}

TEST(Language, VerticesAreMerged) {
  EXPECT_EQ(RetiredPartOf("VertexWelder", "engrave/mesh/weld_vertices.h"), "");
  EXPECT_EQ(RetiredPartOf("VertexWelder", "engrave/discretize/cloud.cc"), "welder");
}

TEST(Language, CommentsAndLiteralsAreNoNames) {
  EXPECT_THAT(
      IdentifiersOf("int a;  // told\n/* say */ b(\"most \\\" least\", 'c', 1'000);\n"
                    "R\"x(look)x\" d2"),
      ElementsAre("int", "a", "b", "d2"));
}

TEST(Language, ARetiredNameIsFoundWithItsFile) {
  const fs::path root = test::FreshFolder();
  fs::create_directories(root / "engrave/core");
  std::ofstream(root / "engrave/core/a.h") << "int kMost = 1;\nint kMax = kMost;\n";
  EXPECT_THAT(RetiredNames(root),
              ElementsAre(::testing::AllOf(HasSubstr("engrave/core/a.h"),
                                           HasSubstr("kMost"), HasSubstr("glossary"))));
}

TEST(Language, CommentsAreSentences) {
  EXPECT_THAT(CommentsThatBeginWithOf(INTAGLIO_SOURCE_DIR), IsEmpty());
}

TEST(Language, ACommentThatBeginsWithOfIsFoundWithItsLine) {
  const fs::path root = test::FreshFolder();
  fs::create_directories(root / "services/cell");
  std::ofstream(root / "services/cell/a.h")
      << "// Offers a place. Of two it takes the first.\n"
         "int a;  ///< "
         "Of a cell.\nint b;  // Often 0.\n";
  EXPECT_THAT(CommentsThatBeginWithOf(root),
              ElementsAre(HasSubstr("services/cell/a.h:2: ")));
}

}  // namespace
}  // namespace intaglio::walls
