#pragma once

// One participant of a secured shop in this process, and strangers (stranger.cc) in
// processes of their own. That samples of a stranger were not received counts only when
// those of a later writer with the right identity were.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <regex>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/identity.h"
#include "services/platform/security/certificates.h"
#include "services/platform/security/identity_folders.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::testing {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Eventually;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Running;
using testing::TextIn;

// After the right one was received, the wrong one gets this long again.
inline constexpr auto kAbsence = 1000ms;
// An identity is proved within a second, on a busy host within seconds. On one with
// twenty times its work (load 40 on 2 cores) a handshake was seen to stop half way; the
// library begins it anew after 100 s, a new process at once.
inline constexpr auto kArrival = 40s;
inline constexpr int kTries = 4;

inline std::chrono::sys_seconds Now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

inline security::ShopOptions TwoCells() {
  security::ShopOptions shop;
  shop.cells = {"els-03", "els-04"};
  return shop;
}

class Security : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!bus::SecurityConfiguration({folder_, {}, {}})) {
      GTEST_SKIP()
          << "the DDS library has no security plugins: install Cyclone DDS built "
             "with ENABLE_SECURITY";
    }
    ASSERT_TRUE(security::NewIdentities(folder_ / "shop", TwoCells(), {Now()}));
  }

  fs::path Of(const std::string& role) const { return folder_ / "shop" / role; }
  /// A copy of a role's folder, to be spoilt.
  fs::path CopyOf(const std::string& role, const std::string& name) const {
    fs::copy(Of(role), folder_ / name);
    return folder_ / name;
  }
  bus::BusOptions As(const std::string& role) const {
    bus::BusOptions options;
    options.tag = Tag();
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

  struct Received {
    int right = 0, wrong = 0;
  };
  /// A process with `listener`'s identity reads the topic; one with the wrong identity
  /// writes it, then one with the right identity, until its samples were received.
  Received Receive(const std::string& topic, const std::string& cell,
                   const std::string& listener, const fs::path& wrong,
                   const fs::path& right) {
    const auto ear = Stranger("listener", Of(listener), {"hear", topic, cell});
    wrong_ = Stranger("wrong", wrong, {"write", topic, cell, "wrong"});
    const auto sent = [](const std::unique_ptr<Running>& who) {
      return Eventually([&] { return !who->Output().empty(); }, kArrival);
    };
    EXPECT_TRUE(sent(ear) && sent(wrong_));
    std::unique_ptr<Running> good;
    const auto received_right = [&] { return CountOf("right", *ear) > 0; };
    for (int i = 0; i < kTries && !received_right(); ++i) {
      good.reset();
      good =
          Stranger("right" + std::to_string(i), right, {"write", topic, cell, "right"});
      Eventually(received_right, kArrival);
    }
    EXPECT_TRUE(received_right()) << ear->Output() << good->Output();
    Eventually([] { return false; }, kAbsence);
    const Received received{CountOf("right", *ear), CountOf("wrong", *ear)};
    std::cout << "  " << topic << ": the right one was heard " << received.right
              << " times, the wrong one " << received.wrong << " times; it said: "
              << std::regex_replace(wrong_->Output(), std::regex("\n"), "; ") << "\n";
    return received;
  }
  /// Reads a count from a listener's lines `heard ("right", 12) ("wrong", 3)`.
  static int CountOf(const std::string& word, const Running& listener) {
    const std::string text = listener.Output();
    const auto line = text.rfind("heard ");
    const std::regex count("\"" + word + "\", ([0-9]+)");
    std::smatch found;
    if (line == std::string::npos) return 0;
    const std::string last = text.substr(line);
    return std::regex_search(last, found, count) ? std::stoi(found[1]) : 0;
  }

  /// The job service receives commands of the operator and none of `wrong`.
  void ExpectNoCommandOf(const fs::path& wrong) {
    Expect(Receive("JobCommand", "", "job-service", wrong, Of("operator")));
  }
  /// A cell receives permissions of the job service and none of `wrong`.
  void ExpectNoPermissionOf(const fs::path& wrong) {
    Expect(Receive("Permission", "els-03", "cell-els-03", wrong, Of("job-service")));
  }
  void ExpectNoStopOf(const fs::path& wrong) {
    Expect(Receive("EmergencyStop", "els-03", "cell-els-03", wrong, Of("operator")));
  }
  static void Expect(const Received& received) {
    EXPECT_EQ(received.wrong, 0);
    EXPECT_GT(received.right, 0);
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

  fs::path folder_ = test::FreshFolder();
  std::unique_ptr<Running> wrong_;
};

}  // namespace intaglio::testing
