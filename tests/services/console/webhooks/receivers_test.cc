#include "services/console/webhooks/receivers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

constexpr char kGood[] =
    R"(name: "erp" url: "https://erp.example/hooks/abc" secret_file: "erp.secret")";

std::string Receivers(const std::string& fields) {
  return "receivers { " + fields + " }";
}

/// The message with which receivers of this text are refused; "" when they are not.
std::string Refusal(const std::string& fields) {
  const auto parsed = ParseReceivers(Receivers(fields), "hooks");
  return parsed ? "" : parsed.error().message;
}

std::string WithUrl(const std::string& url, const std::string& more = {}) {
  return "name: \"erp\" secret_file: \"s\" url: \"" + url + "\" " + more;
}

TEST(WebhookReceivers, HttpsIsNeededBeyondThisComputer) {
  EXPECT_EQ(Refusal(WithUrl("https://erp.example/hooks")), "");
  for (const char* here : {"localhost", "127.0.0.1:8080", "127.5.5.5", "[::1]:80"})
    EXPECT_EQ(Refusal(WithUrl(std::string("http://") + here + "/x")), "") << here;
  for (const char* elsewhere :
       {"erp.example", "127.evil.example", "192.0.2.1", "localhost.evil.example"}) {
    const std::string url = std::string("http://") + elsewhere + "/x";
    EXPECT_THAT(Refusal(WithUrl(url)),
                AllOf(HasSubstr("hooks: receivers[0].url: \"http://" +
                                std::string(elsewhere) + "\""),
                      HasSubstr("give https://"), HasSubstr("allow_plain_http")));
    EXPECT_EQ(Refusal(WithUrl(url, "allow_plain_http: true")), "");
  }
}

TEST(WebhookReceivers, EachWrongFieldIsNamedWithItsValueAndARemedy) {
  EXPECT_EQ(Refusal(kGood), "");
  EXPECT_THAT(Refusal(""), AllOf(HasSubstr("receivers[0].name: "),
                                 HasSubstr("receivers[0].url: is missing; give https://"),
                                 HasSubstr("secret_file: is missing; make one: (umask")));
  EXPECT_THAT(Refusal(WithUrl("ftp://erp.example/x")),
              AllOf(HasSubstr("\"ftp://erp.example\" is of ftp"), HasSubstr("https://")));
  EXPECT_THAT(Refusal(WithUrl("https://erp example/x")), HasSubstr("is no URL"));
  EXPECT_THAT(Refusal(WithUrl("https://u:hidden@erp.example/token")),
              AllOf(HasSubstr("\"https://erp.example\" has a user or a password; leave"),
                    Not(HasSubstr("hidden")), Not(HasSubstr("token"))));
  EXPECT_THAT(Refusal(WithUrl("https://erp.example/" + std::string(2000, 'x'))),
              HasSubstr("has 2020 bytes; give at most 2000"));
  EXPECT_THAT(Refusal(std::string(kGood) + R"( events: "ended" events: "finished")"),
              AllOf(HasSubstr("receivers[0].events: \"finished\" is no kind of event"),
                    HasSubstr("progress, ended")));
  EXPECT_THAT(Refusal(R"(name: "two words" url: "https://e" secret_file: "s")"),
              HasSubstr("receivers[0].name: \"two words\" is no name"));
  EXPECT_THAT(Refusal(R"(nam: "erp")"), HasSubstr("Did you mean name?"));
  const auto twice = ParseReceivers(Receivers(kGood) + Receivers(kGood), "hooks");
  ASSERT_FALSE(twice);
  EXPECT_THAT(twice.error().message, HasSubstr("receivers[1].name: \"erp\" is that of"));
  const auto none = ParseReceivers("", "hooks");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("receivers: there are 0; give 1 to 16"));
}

class WebhookSecret : public ::testing::Test {
 protected:
  WebhookSecret() {
    std::ofstream(file_) << Receivers(std::string(kGood) + more_);
    WriteSecret("0123456789abcdef\n");
  }
  void WriteSecret(const std::string& text) const {
    std::ofstream(secret_) << text;
    fs::permissions(secret_, fs::perms::owner_read | fs::perms::owner_write);
  }
  std::string ReadRefusal() const {
    const auto read = ReadReceivers(file_);
    return read ? "" : read.error().message;
  }
  const std::string more_ = R"( events: "ended" events: "state" ca_file: "ca.pem")";
  const fs::path folder_ = test::FreshFolder();
  const fs::path file_ = folder_ / "hooks";
  const fs::path secret_ = folder_ / "erp.secret";
};

TEST_F(WebhookSecret, IsReadBesideTheFileWithoutTheEndOfItsLine) {
  std::ofstream(folder_ / "ca.pem") << "-----BEGIN CERTIFICATE-----\n";
  const auto read = ReadReceivers(file_);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 1u);
  const Receiver& receiver = read->front();
  EXPECT_EQ(receiver.secret, "0123456789abcdef");
  EXPECT_EQ(receiver.place, "https://erp.example:443");
  EXPECT_EQ(receiver.ca_file, (folder_ / "ca.pem").string());
  EXPECT_THAT(receiver.events, UnorderedElementsAre("ended", "state"));
  EXPECT_TRUE(receiver.Wants("ended"));
  EXPECT_FALSE(receiver.Wants("progress"));
  EXPECT_TRUE(Receiver().Wants("progress"));
}

TEST_F(WebhookSecret, IsRefusedWhenItIsShortOrOthersCanReadIt) {
  EXPECT_THAT(ReadRefusal(), HasSubstr("receivers[0].ca_file: "));
  std::ofstream(folder_ / "ca.pem") << "no certificate";
  EXPECT_THAT(ReadRefusal(), HasSubstr("has no certificate; give a PEM file"));
  WriteSecret("0123456789abcde\n");
  EXPECT_THAT(ReadRefusal(), AllOf(HasSubstr("receivers[0].secret_file: "),
                                   HasSubstr("a secret of 15 bytes; give 16 to 1024"),
                                   Not(HasSubstr("0123456789"))));
  WriteSecret("0123456789abcdef");
  fs::permissions(secret_, fs::perms::others_read, fs::perm_options::add);
  EXPECT_THAT(ReadRefusal(), AllOf(HasSubstr("receivers[0].secret_file: "),
                                   HasSubstr("others can read or write it: chmod 600")));
  fs::remove(secret_);
  EXPECT_THAT(ReadRefusal(), HasSubstr("receivers[0].secret_file: "));
}

}  // namespace
}  // namespace intaglio::console
