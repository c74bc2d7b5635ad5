#pragma once

// The supplied templates of contours and holes, parsed.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "engrave/post/drill_program.h"
#include "engrave/post/mill_program.h"
#include "tests/test_folder.h"

namespace intaglio::post::fixture {

inline std::filesystem::path SuppliedFile(const std::string& kind,
                                          const std::string& name) {
  return std::filesystem::path(INTAGLIO_SOURCE_DIR) / "deploy/post" / kind /
         (name + ".post");
}

inline Template SuppliedMill(const std::string& name) {
  const auto file = SuppliedFile("mill", name);
  auto parsed = ParseMillTemplate(intaglio::test::ContentOf(file), file.string());
  EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
  return parsed.value_or(Template{});
}

inline Template SuppliedDrill(const std::string& name) {
  const auto file = SuppliedFile("drill", name);
  auto parsed = ParseDrillTemplate(intaglio::test::ContentOf(file), file.string());
  EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
  return parsed.value_or(Template{});
}

}  // namespace intaglio::post::fixture
