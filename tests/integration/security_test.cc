// Who may command the laser: strangers whose samples are not received.

#include "services/platform/bus/samples.h"
#include "tests/integration/secured_strangers.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::kAbsence;
using testing::kArrival;
using ::testing::Not;
using testing::Now;
using testing::Security;
using testing::TwoCells;

TEST_F(Security, NoCertificateIsNotReceived) {
  ExpectNoCommandOf({});
  EXPECT_THAT(wrong_->Output(), Not(HasSubstr("matched")));
  ExpectNoPermissionOf({});
  ExpectNoStopOf({});
}

TEST_F(Security, AnotherShopsOperatorIsNotReceived) {
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

TEST_F(Security, ACellMayWriteForItselfOnly) {
  Expect(Receive("MotionState", "els-03", "cell-els-03", Of("cell-els-04"),
                 Of("cell-els-03")));
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
  const security::KeyPair own{testing::TextIn(Of("observer") / bus::kCertificateFile),
                              testing::TextIn(Of("observer") / bus::kPrivateKeyFile)};
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
