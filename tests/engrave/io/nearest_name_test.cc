#include "engrave/io/nearest_name.h"

#include <gtest/gtest.h>

namespace intaglio::io {
namespace {

TEST(NearestName, IsWhatWasProbablyMeant) {
  const std::vector<std::string> known = {"submit", "stop", "show", "list"};
  EXPECT_EQ(NearestName("sumbit", known), "submit") << "two letters changed places";
  EXPECT_EQ(NearestName("submt", known), "submit") << "left out";
  EXPECT_EQ(NearestName("lists", known), "list") << "put in";
  EXPECT_EQ(NearestName("shop", known), "stop") << "nearer ones first, then the first";
  EXPECT_EQ(NearestName("engrave", known), std::nullopt);
  EXPECT_EQ(NearestName("ls", known), std::nullopt) << "too short to say";
  EXPECT_EQ(NearestName("", known), std::nullopt);
  EXPECT_EQ(NearestName("list", {}), std::nullopt);
}

}  // namespace
}  // namespace intaglio::io
