#include "services/console/console_address.h"

#include <gtest/gtest.h>

#include <fstream>

#include "services/console/api.h"
#include "services/platform/access/new_key.h"
#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

TEST(ConsoleAddress, ComesBackFromItsFileWhichOnlyItsUserReads) {
  const auto file = test::FreshFolder() / "console.address";
  const ConsoleAddress address{.port = 8850, .key = access::NewKey()};
  ASSERT_TRUE(WriteAddressFile(file, address));
  const auto read = ReadAddressFile(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->port, 8850);
  EXPECT_EQ(read->key, address.key);
  using std::filesystem::perms;
  EXPECT_EQ(std::filesystem::status(file).permissions() & perms::mask,
            perms::owner_read | perms::owner_write);
}

TEST(ConsoleAddress, AnotherTextIsNone) {
  const std::string key(64, 'a');
  EXPECT_TRUE(ParseAddress("http://127.0.0.1:8850/?key=" + key));
  EXPECT_TRUE(ParseAddress("http://[::1]:8850/?key=" + key));
  const std::string network = "https://shop.example:8850/";
  const auto without_key = ParseAddress(network);
  ASSERT_TRUE(without_key);
  EXPECT_EQ(without_key->key, "");
  EXPECT_EQ(TextOf(*without_key), network);
  for (const std::string& wrong :
       {std::string(), "http://127.0.0.1:0/?key=" + key,
        "http://127.0.0.1:99999/?key=" + key, "http://127.0.0.1:1/?key=" + key + "a",
        "http://evil:1/?key=" + key, std::string("http://127.0.0.1:1/?key=")}) {
    EXPECT_FALSE(ParseAddress(wrong)) << wrong;
  }
}

TEST(ConsoleRequests, AreStopsAndNothingElse) {
  const auto stop = ParseConsoleRequest(R"({"stop": {"reason": "smoke"}})");
  ASSERT_TRUE(stop);
  EXPECT_EQ(stop->stop().reason(), "smoke");
  for (const char* wrong : {"", "[]", "{\"arm\": {}}", "{\"stop\": 1}", "no json"})
    EXPECT_FALSE(ParseConsoleRequest(wrong)) << wrong;
}

}  // namespace
}  // namespace intaglio::console
