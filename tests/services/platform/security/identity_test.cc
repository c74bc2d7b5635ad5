// What an honest program reports about its own files before it joins.
// tests/integration/security_test.cc shows that other programs are refused all the same.

#include "services/platform/bus/identity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/topics.h"
#include "services/platform/security/certificates.h"
#include "services/platform/security/identity_folders.h"
#include "services/platform/security/roles.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using std::chrono::days;
using ::testing::AllOf;
using ::testing::HasSubstr;

// 2026-11-21 12:00 UTC
constexpr std::chrono::sys_seconds kNow{std::chrono::seconds(1795262400)};

std::string TextIn(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

class IdentityFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const security::ShopOptions shop{"Test shop", {"els-03"}, {40, 60}};
    ASSERT_TRUE(security::NewIdentities(shop_, shop, {kNow, 10, 100}));
  }

  Result<bus::Identity> Read(std::chrono::sys_seconds now = kNow, int domain = 40) const {
    return bus::ReadIdentity(sorter_, domain, now);
  }
  /// The error message; it has to name the file.
  std::string Complaint(const std::string& file, std::chrono::sys_seconds now = kNow,
                        int domain = 40) const {
    const auto identity = Read(now, domain);
    EXPECT_FALSE(identity);
    if (identity) return {};
    EXPECT_THAT(identity.error().message, HasSubstr((sorter_ / file).string()));
    std::cout << "  " << identity.error().message << "\n";
    return identity.error().message;
  }
  void Replace(const char* file, const std::string& from, const std::string& to) const {
    std::string text = TextIn(sorter_ / file);
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    std::ofstream(sorter_ / file) << text.replace(at, from.size(), to);
  }
  void CopyFromForeign(const char* file) const {
    ASSERT_TRUE(security::NewIdentities(
        folder_ / "foreign", {"Test shop", {"els-03"}, {40}}, {kNow, 10, 100}));
    fs::copy(folder_ / "foreign" / "stage-worker" / file, sorter_ / file,
             fs::copy_options::overwrite_existing);
  }

  fs::path folder_ = test::FreshFolder();
  fs::path shop_ = folder_ / "shop";
  fs::path sorter_ = shop_ / "stage-worker";
};

TEST_F(IdentityFiles, AreGoodAsMade) {
  for (const security::Role& role : security::RolesOf({"els-03"})) {
    for (const int domain : {40, 60}) {
      const auto identity = bus::ReadIdentity(shop_ / role.name, domain, kNow);
      ASSERT_TRUE(identity) << identity.error().message;
      EXPECT_EQ(identity->role, role.name);
      EXPECT_EQ(identity->not_after, kNow + days(10));
    }
  }
}

TEST_F(IdentityFiles, KeepPrivateKeysToTheirOwner) {
  int keys = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    struct stat status = {};
    ASSERT_EQ(stat(entry.path().c_str(), &status), 0);
    const bool secret = name == bus::kPrivateKeyFile || name.ends_with(".key");
    if (secret || entry.is_directory()) {
      EXPECT_EQ(status.st_mode & 0077, 0u) << entry.path();
    }
    if (entry.is_regular_file()) {
      EXPECT_EQ(TextIn(entry.path()).find("PRIVATE KEY") != std::string::npos, secret)
          << entry.path();
    }
    keys += secret ? 1 : 0;
  }
  EXPECT_EQ(keys, 2 + 7);  // two authorities, seven roles
}

TEST_F(IdentityFiles, AMissingFolderNamesTheRemedy) {
  const auto identity = bus::ReadIdentity(folder_ / "nowhere", 40, kNow);
  ASSERT_FALSE(identity);
  EXPECT_THAT(identity.error().message,
              AllOf(HasSubstr("nowhere"), HasSubstr("intaglio security new")));
}

TEST_F(IdentityFiles, EachMissingOrEmptyFileIsNamed) {
  for (const char* file :
       {bus::kCertificateFile, bus::kPrivateKeyFile, bus::kIdentityAuthorityFile,
        bus::kPermissionsAuthorityFile, bus::kGovernanceFile, bus::kPermissionsFile}) {
    const std::string text = TextIn(sorter_ / file);
    fs::remove(sorter_ / file);
    EXPECT_THAT(Complaint(file), HasSubstr("No such file"));
    std::ofstream(sorter_ / file).flush();
    EXPECT_THAT(Complaint(file), HasSubstr("it is empty"));
    std::ofstream(sorter_ / file) << text;
    chmod((sorter_ / file).c_str(), 0600);
    EXPECT_TRUE(Read());
  }
}

TEST_F(IdentityFiles, AKeyThatOthersMayReadIsNotTaken) {
  chmod((sorter_ / bus::kPrivateKeyFile).c_str(), 0640);
  EXPECT_THAT(Complaint(bus::kPrivateKeyFile), HasSubstr("chmod 600"));
}

TEST_F(IdentityFiles, NoCertificateAndNoKeyAreReported) {
  Replace(bus::kCertificateFile, "CERTIFICATE", "CERTIFICATION");
  EXPECT_THAT(Complaint(bus::kCertificateFile), HasSubstr("not a certificate"));
}

TEST_F(IdentityFiles, AnothersKeyIsReported) {
  fs::copy(shop_ / "operator" / bus::kPrivateKeyFile, sorter_ / bus::kPrivateKeyFile,
           fs::copy_options::overwrite_existing);
  EXPECT_THAT(Complaint(bus::kPrivateKeyFile), HasSubstr("is not the key of"));
}

TEST_F(IdentityFiles, AForeignAuthorityIsReported) {
  CopyFromForeign(bus::kIdentityAuthorityFile);
  EXPECT_THAT(Complaint(bus::kCertificateFile), HasSubstr("not signed by the authority"));
}

TEST_F(IdentityFiles, AForeignPermissionsAuthorityIsReported) {
  CopyFromForeign(bus::kPermissionsAuthorityFile);
  EXPECT_THAT(Complaint(bus::kGovernanceFile), HasSubstr("was not signed by"));
}

TEST_F(IdentityFiles, TamperedDocumentsAreReported) {
  Replace(bus::kPermissionsFile, "<topic>PointBatch", "<topic>Permission");
  EXPECT_THAT(Complaint(bus::kPermissionsFile), HasSubstr("changed after it was signed"));
  Replace(bus::kGovernanceFile, "ENCRYPT", "NONE");
  EXPECT_THAT(Complaint(bus::kGovernanceFile), HasSubstr("changed after it was signed"));
}

TEST_F(IdentityFiles, AnothersPermissionsAreReported) {
  fs::copy(shop_ / "operator" / bus::kPermissionsFile, sorter_ / bus::kPermissionsFile,
           fs::copy_options::overwrite_existing);
  EXPECT_THAT(Complaint(bus::kPermissionsFile),
              AllOf(HasSubstr("CN=operator"), HasSubstr("CN=stage-worker")));
}

TEST_F(IdentityFiles, ExpiryIsReportedWithItsDayAndTheRemedy) {
  EXPECT_TRUE(Read(kNow + days(10) - 1s));
  EXPECT_THAT(Complaint(bus::kCertificateFile, kNow + days(11)),
              AllOf(HasSubstr("expired on 2026-12-01 12:00 UTC"),
                    HasSubstr("intaglio security renew")));
  EXPECT_THAT(Complaint(bus::kCertificateFile, kNow - days(1)),
              AllOf(HasSubstr("valid from 2026-11-21"), HasSubstr("clock")));
}

TEST_F(IdentityFiles, RenewalGivesNewKeysByTheSameAuthorities) {
  const std::string key = TextIn(sorter_ / bus::kPrivateKeyFile);
  const std::string authority = TextIn(sorter_ / bus::kIdentityAuthorityFile);
  const auto shop = security::RenewIdentities(shop_, {"els-04"}, {kNow + days(9), 30});
  ASSERT_TRUE(shop);
  EXPECT_EQ(shop->cells, (std::vector<std::string>{"els-03", "els-04"}));
  EXPECT_NE(TextIn(sorter_ / bus::kPrivateKeyFile), key);
  EXPECT_EQ(TextIn(sorter_ / bus::kIdentityAuthorityFile), authority);
  const auto identity = Read(kNow + days(11), 60);
  ASSERT_TRUE(identity) << identity.error().message;
  EXPECT_EQ(identity->not_after, kNow + days(39));
  EXPECT_TRUE(bus::ReadIdentity(shop_ / "cell-els-04", 40, kNow + days(11)));
}

TEST_F(IdentityFiles, AnotherDomainIsReported) {
  EXPECT_THAT(Complaint(bus::kPermissionsFile, kNow, 50),
              AllOf(HasSubstr("domain 40, 60, not for 50"), HasSubstr("--domain")));
}

TEST_F(IdentityFiles, NamesThatWouldBeMoreThanNamesAreRefused) {
  for (const char* cell : {"", "*", "a/b", "../x", "<partition>", "els 03"}) {
    EXPECT_FALSE(security::NewIdentities(folder_ / "bad", {"Shop", {cell}, {40}}, {kNow}))
        << cell;
  }
  EXPECT_FALSE(fs::exists(folder_ / "bad"));
}

TEST_F(IdentityFiles, TheRolesFolderIsFound) {
  EXPECT_EQ(bus::IdentityFolder(shop_, {"operator", "observer"}), shop_ / "operator");
  EXPECT_EQ(bus::IdentityFolder(sorter_, {"operator"}), sorter_);
  fs::remove_all(shop_ / "operator");
  EXPECT_EQ(bus::IdentityFolder(shop_, {"operator", "observer"}), shop_ / "observer");
  fs::remove_all(shop_ / "observer");
  EXPECT_EQ(bus::IdentityFolder(shop_, {"operator", "observer"}), shop_ / "operator");
}

TEST(BusWithoutIdentity, DoesNotLeaveLoopback) {
  bus::BusOptions options;
  options.interface = "eth0";
  try {
    bus::Bus bus(options);
    FAIL() << "it left";
  } catch (const bus::BusError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("--interface eth0"), HasSubstr("--security")));
  }
}

// ---- The table of roles --------------------------------------------------------

std::set<std::string> Writers(const std::string& topic) {
  std::set<std::string> names;
  for (const security::Role& role : security::RolesOf({"els-03"})) {
    for (const security::RoleTopic& written : role.writes) {
      if (written.name == topic) names.insert(role.name);
    }
  }
  return names;
}

// What moves and fires has one kind of writer each.
TEST(Roles, OnlyTheRightOnesCommand) {
  using Names = std::set<std::string>;
  EXPECT_EQ(Writers("Permission"), Names{"job-service"});
  EXPECT_EQ(Writers("EngraveTask"), Names{"job-service"});
  EXPECT_EQ(Writers("JobStatus"), Names{"job-service"});
  EXPECT_EQ(Writers("JobSubmission"), (Names{"operator", "submitter"}));
  // To arm, move and light.
  EXPECT_EQ(Writers("JobCommand"), Names{"operator"});
  EXPECT_EQ(Writers("ManualCommand"), Names{"operator"});
  EXPECT_EQ(Writers("JobCommandAnswer"), Names{"job-service"});
  EXPECT_EQ(Writers("MotionSegmentBatch"), Names{"cell-els-03"});
  EXPECT_EQ(Writers("PathBatch"), Names{"stage-worker"});
  EXPECT_TRUE(Writers("EmergencyStop").contains("operator"));
  EXPECT_TRUE(Writers("EmergencyStop").contains("submitter"));
  EXPECT_FALSE(Writers("EmergencyStop").contains("observer"));
}

TEST(Roles, ReadersWriteNothingButTheirHealth) {
  for (const security::Role& role : security::RolesOf({})) {
    if (role.name == "observer") {
      EXPECT_TRUE(role.writes.empty());
    }
    if (role.name != "recorder") continue;
    for (const security::RoleTopic& topic : role.writes) {
      EXPECT_THAT((std::set<std::string>{"ServiceHealth", "Alarm"}),
                  ::testing::Contains(topic.name));
    }
  }
}

// Permissions are by exact name: a pattern would allow topics that were not intended.
TEST(Roles, NoTopicIsAPattern) {
  for (const security::Role& role : security::RolesOf({"els-03"})) {
    const std::string text = security::PermissionsText(role, "CN=x", {40}, {kNow, kNow});
    EXPECT_EQ(text.find("<topic>*"), std::string::npos);
    EXPECT_NE(text.find("<default>DENY</default>"), std::string::npos);
    if (role.name.starts_with(bus::kCellPrefix)) {
      EXPECT_EQ(text.find("<partition>*"), std::string::npos);
    }
  }
}

// So that no role can be another in what several write.
TEST(Roles, WhatSeveralWriteIsWrittenInThePartitionOfTheRole) {
  for (const security::Role& role : security::RolesOf({"els-03", "els-04"})) {
    for (const security::RoleTopic& topic : role.writes) {
      const std::string partition = security::WritePartition(role, topic);
      const bool shared = Writers(topic.name).size() > 1;
      if (topic.scope == bus::Scope::kRole) {
        EXPECT_EQ(partition, "role/" + role.name) << topic.name;
      } else if (shared && std::string(topic.name) != "JobSubmission") {
        // A submission asks for the same, whoever has written it.
        EXPECT_EQ(topic.scope, bus::Scope::kCell) << topic.name;
      }
    }
  }
}

// A participant that acknowledges nothing makes no other leave the bus: only those are
// asked whose loss matters.
TEST(Roles, OnlyThoseThatDependOnEachOtherReadPresence) {
  std::map<std::string, std::string> readers;
  for (const security::Role& role : security::RolesOf({"els-03", "els-04"})) {
    for (const security::RoleTopic& topic : role.reads) {
      if (topic.name != std::string("Presence")) continue;
      readers[role.name] = security::ReadPartition(role, topic);
    }
  }
  const std::map<std::string, std::string> expected = {
      {"job-service", "*"},
      {"cell-els-03", "role/job-service"},
      {"cell-els-04", "role/job-service"}};
  EXPECT_EQ(readers, expected);
}

std::set<std::string> NamesOf(const std::vector<security::RoleTopic>& topics) {
  std::set<std::string> names;
  for (const security::RoleTopic& topic : topics) {
    names.insert(std::string(topic.name) +
                 (topic.scope == bus::Scope::kCell ? "\u00b0" : ""));
  }
  return names;
}

std::set<std::string> NamesIn(const std::string& cell) {
  std::set<std::string> names;
  std::istringstream words(cell);
  for (std::string word; words >> word;) {
    if (word.ends_with(',')) word.pop_back();
    if (word != "nothing") names.insert(word);
  }
  return names;
}

TEST(Roles, AreInTheDocumentationAsTheyAre) {
  std::istringstream document(TextIn(INTAGLIO_SOURCE_DIR "/docs/deployment.md"));
  std::set<std::string> seen;
  const auto roles = security::RolesOf({"NAME"});
  for (std::string line; std::getline(document, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, '|');) cells.push_back(cell);
    for (const security::Role& role : roles) {
      if (cells.size() != 5 || cells[1] != " `" + role.name + "` ") continue;
      seen.insert(role.name);
      EXPECT_EQ(NamesIn(cells[3]), NamesOf(role.writes)) << role.name;
      if (role.name != "recorder") {
        EXPECT_EQ(NamesIn(cells[4]), NamesOf(role.reads)) << role.name;
      }
    }
  }
  EXPECT_EQ(seen.size(), roles.size());
}

TEST(Roles, TheRecorderReceivesEveryTopic) {
  std::set<std::string> all;
  bus::ForEveryTopic([&all](const auto& topic) { all.insert(topic.name); });
  for (const security::Role& role : security::RolesOf({})) {
    if (role.name != "recorder") continue;
    for (const security::RoleTopic& topic : role.reads) all.erase(topic.name);
  }
  // Its writers wait for who reads it; there is nothing in it.
  EXPECT_EQ(all.erase("Presence"), 1u);
  EXPECT_TRUE(all.empty()) << ::testing::PrintToString(all);
}

}  // namespace
}  // namespace intaglio
