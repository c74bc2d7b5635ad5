#include "services/platform/web/request_rules.h"

#include <gtest/gtest.h>

namespace intaglio::web {
namespace {

TEST(RequestRules, SplitsAndDecodesATarget) {
  const auto target = ParseTarget("/api/v1/jobs/7%20a?from=3&name=a%26b&flag&from=4");
  ASSERT_TRUE(target) << target.error().message;
  EXPECT_EQ(target->path, "/api/v1/jobs/7 a");
  EXPECT_EQ(target->query.at("from"), "3");
  EXPECT_EQ(target->query.at("name"), "a&b");
  EXPECT_EQ(target->query.at("flag"), "");
}

TEST(RequestRules, RefusesWhatClimbsOutOrIsNoPath) {
  for (const char* wrong : {"", "*", "http://a/", "/..", "/../etc/passwd", "/a/../b",
                            "/a/.", "/%2e%2e/a", "/a%2f..%2fb", "/a\\b", "/a%5cb", "/%",
                            "/%4", "/%zz", "/a%00b", "/?a=%0d", "/a%0a"}) {
    EXPECT_FALSE(ParseTarget(wrong)) << wrong;
  }
  EXPECT_TRUE(ParseTarget("/a..b/.c"));
}

TEST(RequestRules, OnlyNamesOfThisComputerAreOwnHosts) {
  const OwnNames own{.port = 8850};
  EXPECT_TRUE(IsOwnHost("127.0.0.1:8850", own));
  EXPECT_TRUE(IsOwnHost("localhost:8850", own));
  for (const char* foreign :
       {"", "127.0.0.1", "127.0.0.1:8851", "evil.example:8850", "127.0.0.1.evil:8850",
        "localhost:8850.evil", "LOCALHOST:8850"}) {
    EXPECT_FALSE(IsOwnHost(foreign, own)) << foreign;
  }
  EXPECT_TRUE(IsOwnOrigin("http://localhost:8850", own));
  for (const char* foreign : {"null", "https://localhost:8850", "http://evil:8850",
                              "http://localhost:8850/", "http://localhost"}) {
    EXPECT_FALSE(IsOwnOrigin(foreign, own)) << foreign;
  }
}

TEST(RequestRules, NamesOfACertificateAreOwnHostsByItsSchemeAlone) {
  const OwnNames own{.is_encrypted = true, .port = 443, .names = {"shop.example"}};
  EXPECT_EQ(OriginOf(own), "https://shop.example");
  EXPECT_TRUE(IsOwnHost("shop.example:443", own));
  EXPECT_TRUE(IsOwnHost("shop.example", own)) << "browsers leave the usual port out";
  EXPECT_FALSE(IsOwnHost("shop.example.evil", own));
  EXPECT_TRUE(IsOwnOrigin("https://shop.example", own));
  EXPECT_FALSE(IsOwnOrigin("http://shop.example", own));
  EXPECT_FALSE(IsOwnOrigin("https://shop.example:8443", own));
}

TEST(RequestRules, ReadsCookiesAndKeys) {
  EXPECT_EQ(CookieIn("a=1; key=2; b=3", "key"), "2");
  EXPECT_EQ(CookieIn("mykey=1", "key"), "");
  EXPECT_EQ(CookieIn("key", "key"), "");
  EXPECT_EQ(BearerKeyIn("Bearer abc"), "abc");
  EXPECT_EQ(BearerKeyIn("Basic abc"), "");
  EXPECT_TRUE(IsSameKey("abc", "abc"));
  EXPECT_FALSE(IsSameKey("abc", "abd"));
  EXPECT_FALSE(IsSameKey("abc", "ab"));
  EXPECT_FALSE(IsSameKey("", ""));
}

}  // namespace
}  // namespace intaglio::web
