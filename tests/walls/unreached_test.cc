#include "tests/walls/unreached.h"

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

class UnreachedTest : public ::testing::Test {
 protected:
  UnreachedTest() : root_(test::FreshFolder()) {
    fs::remove_all(root_);
    fs::create_directories(root_ / "engrave/core");
  }
  void Write(const std::string& file, const std::string& text) const {
    std::ofstream(root_ / "engrave/core" / file) << text;
  }
  fs::path root_;
};

TEST(Unreached, NothingInThisTree) {
  EXPECT_THAT(UnreachedFunctions(INTAGLIO_SOURCE_DIR), IsEmpty());
}

TEST_F(UnreachedTest, FunctionThatIsOnlyDeclaredAndDefinedIsFound) {
  Write("a.h",
        "int Used(int x);\nint Dead(int x);\nstruct A {\n  static A Make();\n"
        "  int* dead_too() const { return nullptr; }\n};\n");
  Write("a.cc",
        "int Used(int x) { return x; }\nint Dead(int x) { return 2 * Used(x); }\n"
        "A A::Make() { return {}; }\n// Dead(1) in a comment\n");
  EXPECT_THAT(UnreachedNames(root_), ElementsAre(Pair("Dead", "engrave/core/a.h"),
                                                 Pair("Make", "engrave/core/a.h"),
                                                 Pair("dead_too", "engrave/core/a.h")));
}

TEST_F(UnreachedTest, EachWayToUseAFunctionIsSeen) {
  for (const char* use :
       {"return Called(1);", "x = 2 * Called(1);", "if (a && Called(1)) b();",
        "p->Called(1);", "Space::Called(1);", "Pass(Called);", "x = a > Called(1);",
        "throw Called(1);", "const auto x = Called(1);", "f(&Called);"}) {
    Write("a.h", "int Called(int x);\n");
    Write("a.cc",
          std::string("int Called(int x) { return x; }\nvoid F() {\n  ") + use + "\n}\n");
    EXPECT_THAT(UnreachedNames(root_), IsEmpty()) << use;
  }
}

}  // namespace
}  // namespace intaglio::walls
