#include "tests/walls/includes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

void WriteFile(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

TEST(Includes, AreWholeWithoutHeadersCompiledAhead) {
  EXPECT_THAT(MissingIncludes(INTAGLIO_SOURCE_DIR), IsEmpty());
}

TEST(Includes, ThatLackAreSeen) {
  const fs::path root = test::FreshFolder();
  fs::remove_all(root);
  WriteFile(root / "engrave/core/a.h", "#include <Eigen/Core>\n#include <map>\n");
  WriteFile(root / "engrave/core/a.cc",
            "#include \"engrave/core/a.h\"\n"
            "auto turned = Eigen::Rotation2Dd(1) * v;\nstd::map<int, int> m;\n");
  WriteFile(root / "tests/b.cc",
            "// std::vector<int>\nauto text = \"std::span<int>\";\n"
            "std::optional<int> x;\n");
  WriteFile(root / "tests/c.cc", "#include <Eigen/Dense>\nauto n = a.cross(b);\n");
  EXPECT_THAT(MissingIncludes(root),
              ElementsAre("engrave/core/a.cc: uses names of <Eigen/Geometry>, include it",
                          "tests/b.cc: uses names of <optional>, include it"));
}

}  // namespace
}  // namespace intaglio::walls
