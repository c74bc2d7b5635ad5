#include "engrave/io/lower_case.h"

#include <gtest/gtest.h>

namespace intaglio::io {
namespace {

TEST(LowerCase, ChangesTheLettersOfAsciiAlone) {
  for (int code = 0; code < 256; ++code) {
    const char c = static_cast<char>(code);
    const bool capital =
        std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZ").find(c) != std::string_view::npos;
    EXPECT_EQ(LowerCase(c), capital ? static_cast<char>(code + 32) : c) << code;
  }
  EXPECT_EQ(LowerCase("Box-Ä.STL"), "box-Ä.stl");
}

TEST(LowerCase, KnowsTheLettersOfAsciiAlone) {
  const std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
  for (int code = 0; code < 256; ++code) {
    const char c = static_cast<char>(code);
    EXPECT_EQ(IsLetter(c), letters.find(c) != std::string_view::npos) << code;
  }
}

TEST(LowerCase, AnExtensionHasNoDot) {
  EXPECT_EQ(LowerCaseExtension(".STL"), "stl");
  EXPECT_EQ(LowerCaseExtension("Dxf"), "dxf");
  EXPECT_EQ(LowerCaseExtension(""), "");
}

}  // namespace
}  // namespace intaglio::io
