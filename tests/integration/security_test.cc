// Who may command the laser. One participant of the shop sits in this process, strangers
// come as processes of their own (stranger.cc). That somebody was not heard is believed
// only when somebody with the right identity, who came later, was.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include "services/bus/bus.h"
#include "services/bus/identity.h"
#include "services/bus/samples.h"
#include "services/security/certificates.h"
#include "services/security/identity_folders.h"
#include "tests/integration/run_program.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Eventually;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Running;

// After the right one was heard, the wrong one gets this long again.
constexpr auto kAbsence = 1000ms;
// A busy host proves an identity in seconds.
constexpr auto kArrival = 60s;

std::chrono::sys_seconds Now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

security::ShopOptions TwoCells() {
  security::ShopOptions shop;
  shop.cells = {"els-03", "els-04"};
  return shop;
}

class Security : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!bus::SecurityConfiguration({folder_, {}, {}})) {
      GTEST_SKIP() << "the DDS library is here without its security plugins";
    }
    ASSERT_TRUE(security::NewIdentities(folder_ / "shop", TwoCells(), {Now()}));
  }

  fs::path Of(const std::string& role) const { return folder_ / "shop" / role; }
  /// A copy of a role's folder, to be spoilt.
  fs::path CopyOf(const std::string& role, const std::string& name) const {
    fs::copy(Of(role), folder_ / name);
    return folder_ / name;
  }
  bus::BusOptions As(const std::string& role, const std::string& cell = {}) const {
    bus::BusOptions options;
    options.tag = Tag();
    options.cell = cell;
    options.security = Of(role);
    return options;
  }
  static std::string Tag() { return "security" + std::to_string(getpid()); }

  std::unique_ptr<Running> Stranger(const std::string& name, const fs::path& identity,
                                    std::vector<std::string> deed) const {
    deed.insert(deed.begin(), {Tag(), identity.empty() ? "-" : identity.string()});
    return std::make_unique<Running>(fs::path(INTAGLIO_STRANGER), deed,
                                     folder_ / (name + ".txt"));
  }

  /// Writes `topic` with a spoilt identity at first and with the good one then, until
  /// the reader has heard the good one. Returns how often each was heard.
  template <typename T>
  std::map<std::string, int> Hear(bus::Reader<T>& reader, char* T::*word,
                                  const fs::path& wrong, const fs::path& right,
                                  const std::string& cell = "") {
    const std::string topic = TopicName(reader);
    std::map<std::string, int> heard;
    wrong_ = Stranger("wrong", wrong, {"write", topic, cell, "wrong"});
    EXPECT_TRUE(Eventually([&] { return !wrong_->Output().empty(); }, kArrival));
    const auto good = Stranger("right", right, {"write", topic, cell, "right"});
    const auto listen = [&] {
      reader.Take([&](const T& sample) { ++heard[sample.*word]; });
      return heard["right"] > 0;
    };
    EXPECT_TRUE(Eventually(listen, kArrival)) << good->Output();
    Eventually([&] { return listen() && false; }, kAbsence);
    Print(topic, heard);
    return heard;
  }
  void Print(const std::string& what, std::map<std::string, int>& heard) const {
    std::cout << "  " << what << ": the right one was heard " << heard["right"]
              << " times, the wrong one " << heard["wrong"] << " times; it said: "
              << std::regex_replace(wrong_->Output(), std::regex("\n"), "; ") << "\n";
  }
  static std::string TopicName(const bus::Reader<intaglio_JobCommand>&) {
    return "JobCommand";
  }
  static std::string TopicName(const bus::Reader<intaglio_EmergencyStop>&) {
    return "EmergencyStop";
  }
  static std::string TopicName(const bus::Reader<intaglio_Permission>&) {
    return "Permission";
  }
  static std::string TopicName(const bus::Reader<intaglio_MotionState>&) {
    return "MotionState";
  }

  /// The job service hears commands of the operator and none of `wrong`.
  void ExpectNoCommandOf(const fs::path& wrong) {
    bus::Bus bus(As("job-service"));
    bus::Reader<intaglio_JobCommand> commands(bus, bus::kJobCommand);
    auto heard =
        Hear(commands, &intaglio_JobCommand::operator_name, wrong, Of("operator"));
    EXPECT_EQ(heard["wrong"], 0);
    EXPECT_GT(heard["right"], 0);
  }
  /// A cell hears permissions of the job service and none of `wrong`.
  void ExpectNoPermissionOf(const fs::path& wrong) {
    bus::Bus bus(As("cell-els-03", "els-03"));
    bus::Reader<intaglio_Permission> permissions(bus, bus::kPermission);
    auto heard = Hear(permissions, &intaglio_Permission::operator_name, wrong,
                      Of("job-service"), "els-03");
    EXPECT_EQ(heard["wrong"], 0);
    EXPECT_GT(heard["right"], 0);
  }
  void ExpectNoStopOf(const fs::path& wrong) {
    bus::Bus bus(As("cell-els-03", "els-03"));
    bus::Reader<intaglio_EmergencyStop> stops(bus, bus::kEmergencyStop);
    auto heard =
        Hear(stops, &intaglio_EmergencyStop::source, wrong, Of("operator"), "els-03");
    EXPECT_EQ(heard["wrong"], 0);
    EXPECT_GT(heard["right"], 0);
  }

  /// The role's certificate with permissions for everything, signed by `signer`.
  fs::path WithForgedPermissions(const std::string& role, const security::KeyPair& signer,
                                 bool own_governance) const {
    const fs::path folder = CopyOf(role, role + "-forged");
    const std::string certificate = TextIn(folder / bus::kCertificateFile);
    security::Role all;
    for (const security::Role& each : security::RolesOf({"els-03"})) {
      all.writes.insert(all.writes.end(), each.writes.begin(), each.writes.end());
      all.reads.insert(all.reads.end(), each.reads.begin(), each.reads.end());
    }
    all.name = role;
    all.partition = "*";
    const security::Validity validity{Now() - 1h, Now() + 24h};
    const std::string subject = security::SubjectOf(certificate).value();
    Put(folder / bus::kPermissionsFile,
        security::Sign(signer, security::PermissionsText(all, subject, {40}, validity))
            .value());
    if (own_governance) {
      Put(folder / bus::kGovernanceFile,
          security::Sign(signer, security::GovernanceText({40})).value());
      Put(folder / bus::kPermissionsAuthorityFile, signer.certificate);
    }
    return folder;
  }
  static std::string TextIn(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  static void Put(const fs::path& file, const std::string& text) {
    std::ofstream(file) << text;
  }
  static void Replace(const fs::path& file, const std::string& from,
                      const std::string& to) {
    std::string text = TextIn(file);
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    Put(file, text.replace(at, from.size(), to));
  }

  fs::path folder_ = testing::FreshFolder(
      std::string("security_") +
      ::testing::UnitTest::GetInstance()->current_test_info()->name());
  std::unique_ptr<Running> wrong_;
};

TEST_F(Security, NoCertificateIsNotHeard) {
  ExpectNoCommandOf({});
  EXPECT_THAT(wrong_->Output(), Not(HasSubstr("matched")));
  ExpectNoPermissionOf({});
  ExpectNoStopOf({});
}

TEST_F(Security, AnotherShopsOperatorIsNotHeard) {
  ASSERT_TRUE(security::NewIdentities(folder_ / "foreign", TwoCells(), {Now()}));
  ExpectNoCommandOf(folder_ / "foreign" / "operator");
  EXPECT_THAT(wrong_->Output(), Not(HasSubstr("matched")));
}

TEST_F(Security, TheObserverMayCommandNothing) {
  ExpectNoCommandOf(Of("observer"));
  EXPECT_THAT(wrong_->Output(), HasSubstr("refused"));
  ExpectNoStopOf(Of("observer"));
  EXPECT_THAT(wrong_->Output(), HasSubstr("writer refused"));
  ExpectNoPermissionOf(Of("observer"));
  EXPECT_THAT(wrong_->Output(), HasSubstr("writer refused"));
}

TEST_F(Security, TheStageWorkerMayNotPermitFiring) {
  ExpectNoPermissionOf(Of("stage-worker"));
  EXPECT_THAT(wrong_->Output(), HasSubstr("refused"));
}

TEST_F(Security, TheOperatorMayNotPermitFiringPastTheJobService) {
  ExpectNoPermissionOf(Of("operator"));
  EXPECT_THAT(wrong_->Output(), HasSubstr("writer refused"));
}

TEST_F(Security, ACellMaySpeakForItselfOnly) {
  bus::Bus bus(As("cell-els-03", "els-03"));
  bus::Reader<intaglio_MotionState> states(bus, bus::kMotionState);
  auto heard = Hear(states, &intaglio_MotionState::message, Of("cell-els-04"),
                    Of("cell-els-03"), "els-03");
  EXPECT_EQ(heard["wrong"], 0);
  EXPECT_THAT(wrong_->Output(), HasSubstr("writer refused"));
}

// The stranger's own library lets it write: the others have to refuse it.
TEST_F(Security, PermissionsOfAnotherAuthorityAreRefusedByTheOthers) {
  const auto forger =
      security::NewAuthority("Intaglio shop", "permissions authority",
                             security::Purpose::kSigner, {Now() - 1h, Now() + 24h});
  ASSERT_TRUE(forger);
  const fs::path forged = WithForgedPermissions("observer", *forger, true);
  ExpectNoPermissionOf(forged);
  EXPECT_THAT(wrong_->Output(), HasSubstr("writes"));
  EXPECT_THAT(wrong_->Output(), Not(HasSubstr("matched")));
}

// An identity signs nothing, although its issuer is trusted for identities.
TEST_F(Security, PermissionsSignedByAnIdentityAreRefused) {
  const security::KeyPair own{TextIn(Of("observer") / bus::kCertificateFile),
                              TextIn(Of("observer") / bus::kPrivateKeyFile)};
  ExpectNoPermissionOf(WithForgedPermissions("observer", own, false));
  EXPECT_THAT(wrong_->Output(), HasSubstr("participant refused"));
}

TEST_F(Security, AnothersPermissionsAreRefused) {
  const fs::path folder = CopyOf("observer", "borrowed");
  fs::copy(Of("operator") / bus::kPermissionsFile, folder / bus::kPermissionsFile,
           fs::copy_options::overwrite_existing);
  ExpectNoCommandOf(folder);
  EXPECT_THAT(wrong_->Output(), HasSubstr("participant refused"));
}

TEST_F(Security, TamperedPermissionsAreRefused) {
  const fs::path folder = CopyOf("observer", "tampered");
  Replace(folder / bus::kPermissionsFile, "<default>DENY", "<default>ALLOW");
  ExpectNoCommandOf(folder);
  EXPECT_THAT(wrong_->Output(), HasSubstr("participant refused"));
}

TEST_F(Security, TamperedGovernanceIsRefused) {
  const fs::path folder = CopyOf("observer", "tampered");
  Replace(folder / bus::kGovernanceFile, "<enable_write_access_control>true",
          "<enable_write_access_control>false");
  ExpectNoCommandOf(folder);
  EXPECT_THAT(wrong_->Output(), HasSubstr("participant refused"));
}

TEST_F(Security, AnExpiredIdentityIsRefused) {
  fs::copy(folder_ / "shop", folder_ / "older", fs::copy_options::recursive);
  const security::Lifetime long_ago{Now() - std::chrono::days(400)};
  ASSERT_TRUE(security::RenewIdentities(folder_ / "older", {}, long_ago));
  ExpectNoCommandOf(folder_ / "older" / "operator");
  EXPECT_THAT(wrong_->Output(), HasSubstr("participant refused"));
}

TEST_F(Security, NothingIsReadWithoutTheRight) {
  bus::Bus bus(As("job-service"));
  bus::Writer<intaglio_JobStatus> status(bus, bus::kJobStatus);
  const std::string secret = "customer's secret";
  intaglio_JobStatus sample{};
  sample.job_uid = sample.submission_uid = sample.name = bus::Borrow(secret);
  ASSERT_TRUE(status.Write(sample));
  ASSERT_TRUE(security::NewIdentities(folder_ / "foreign", TwoCells(), {Now()}));
  const auto plain = Stranger("plain", {}, {"read", "JobStatus", ""});
  const auto foreign =
      Stranger("foreign", folder_ / "foreign" / "observer", {"read", "JobStatus", ""});
  const auto worker = Stranger("worker", Of("stage-worker"), {"read", "JobStatus", ""});
  for (const auto* who : {&plain, &foreign, &worker}) {
    EXPECT_TRUE(Eventually([&] { return !(*who)->Output().empty(); }, kArrival));
  }
  const auto observer = Stranger("observer", Of("observer"), {"read", "JobStatus", ""});
  EXPECT_TRUE(Eventually(
      [&] { return observer->Output().find("read 1") != std::string::npos; }, kArrival));
  std::this_thread::sleep_for(kAbsence);
  for (const auto* who : {&plain, &foreign, &worker, &observer}) {
    std::cout << "  " << std::regex_replace((*who)->Output(), std::regex("\n"), "; ")
              << "\n";
  }
  EXPECT_THAT(plain->Output(), Not(HasSubstr("read 1")));
  EXPECT_THAT(foreign->Output(), Not(HasSubstr("read 1")));
  EXPECT_THAT(worker->Output(), HasSubstr("refused"));
}

}  // namespace
}  // namespace intaglio
