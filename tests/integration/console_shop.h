#pragma once

// A shop of real processes with a console beside it, for tests.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <memory>
#include <optional>
#include <regex>
#include <string>

#include "tests/integration/shop_floor.h"
#include "tests/services/platform/web/web_client.h"
#include "tests/test_folder.h"

namespace intaglio::testing {

class ConsoleShop : public ::testing::Test {
 protected:
  static ShopFloor::Options OnABusOfItsOwn() {
    ShopFloor::Options options;
    options.bus = {"--domain", "46", "--tag", "console" + std::to_string(getpid())};
    return options;
  }
  void Open() {
    console_ = std::make_unique<Running>(
        Program("intaglio-console"),
        floor_.With({"--address-file", address_file_.string(), "--users",
                     users_file_.string(), "--audit", audit_file_.string()}),
        folder_ / fmt::format("console{}.txt", ++starts_));
    std::smatch parts;
    ASSERT_TRUE(Eventually(
        [&] {
          const std::string text = console_->Output();
          return std::regex_search(
                     text, parts,
                     std::regex("http://127.0.0.1:([0-9]+)/.key=([0-9a-f]+)")) &&
                 (port_ = static_cast<std::uint16_t>(std::stoi(parts[1])), true) &&
                 (key_ = parts[2], true);
        },
        std::chrono::seconds(20)))
        << console_->Output();
  }
  test::WebAnswer Get(const std::string& path) const {
    return test::Ask(port_, {.path = path, .key = key_});
  }
  test::WebAnswer Post(const std::string& path, const std::string& body = "{}") const {
    return test::Ask(port_, {.method = "POST", .path = path, .key = key_, .body = body});
  }
  /// In mid-job, at a rate that leaves seconds of it, and known to the console.
  void EngraveSome() {
    floor_.StartAll();
    Open();
    job_ = floor_.Engrave({"--height", "4.2", "--spacing", "0.5", "--rate", "25"});
    ASSERT_TRUE(job_);
    ASSERT_TRUE(floor_.AwaitCracks(20, std::chrono::seconds(40))) << floor_.Logs();
    ASSERT_TRUE(Eventually([&] { return Job().find("engraving") != std::string::npos; },
                           std::chrono::seconds(20)))
        << Job();
  }
  /// Waits until a sample waits for its arm in a machine with a reported block.
  void AwaitArm() {
    floor_.StartAll();
    Open();
    ASSERT_TRUE(floor_.Opens()) << floor_.Logs();
    const Ended mounted = floor_.Type(
        {"mount", "--block", "50", "50", "30", "--index", "1.51947", "--lens", "f43"});
    ASSERT_EQ(mounted.exit_code, 0) << mounted.output;
    const Ended submitted = floor_.Type(
        {"submit", std::string(INTAGLIO_SOURCE_DIR) + "/deploy/jobs/sample.textproto",
         "--height", "4.2", "--spacing", "0.5", "--rate", "25"});
    ASSERT_EQ(submitted.exit_code, 0) << submitted.output;
    std::smatch number;
    ASSERT_TRUE(std::regex_search(submitted.output, number, std::regex("job ([0-9]+)")));
    job_ = number[1];
    ASSERT_TRUE(JobShows("waiting_for_arm")) << Job() << floor_.Logs();
    ASSERT_TRUE(StatusShows("\"mounted\": \"50 x 50 x 30"));
    const std::string status = Get("/api/v1/status").body;
    ASSERT_TRUE(
        std::regex_search(status, number, std::regex("\"mounted\": \"([^\"]+)\"")));
    block_ = number[1];
  }
  bool JobShows(const std::string& text) const {
    return Eventually([&] { return Job().find(text) != std::string::npos; },
                      std::chrono::seconds(30));
  }
  bool StatusShows(const std::string& text) const {
    return Eventually(
        [&] { return Get("/api/v1/status").body.find(text) != std::string::npos; },
        std::chrono::seconds(20));
  }
  test::WebAnswer PostToJob(const std::string& name,
                            const std::string& body = "{}") const {
    return Post("/api/v1/jobs/" + *job_ + "/" + name, body);
  }
  test::WebAnswer Press(const std::string& block) const {
    return PostToJob("hold", fmt::format(R"({{"block": "{}"}})", block));
  }
  /// Presses at the block that is mounted; the body of the arm that ends it.
  std::string Press() const {
    const test::WebAnswer held = Press(block_);
    std::smatch token;
    EXPECT_EQ(held.status, 200) << held.body;
    EXPECT_TRUE(
        std::regex_search(held.body, token, std::regex("\"token\": \"([0-9a-f]{64})\"")))
        << held.body;
    return fmt::format(R"({{"token": "{}"}})", token[1].str());
  }
  void ExpectRefused(const test::WebAnswer& answer, const std::string& code) const {
    EXPECT_EQ(answer.status, 409) << answer.body;
    EXPECT_THAT(answer.body, ::testing::HasSubstr("\"code\": \"" + code + "\""));
  }
  std::string Job() const { return Get("/api/v1/jobs/" + *job_).body; }
  void ExpectNothingFires() {
    const std::int64_t cracks = floor_.Panel("cracks");
    ASSERT_GE(cracks, 0);
    std::this_thread::sleep_for(std::chrono::seconds(3));
    EXPECT_EQ(floor_.Panel("cracks"), cracks) << floor_.Logs();
  }

  std::filesystem::path folder_ = test::FreshFolder();
  std::filesystem::path address_file_ = folder_ / "console.address";
  std::filesystem::path users_file_ = folder_ / "console.users";
  std::filesystem::path audit_file_ = folder_ / "console_audit.jsonl";
  ShopFloor floor_{folder_, OnABusOfItsOwn()};
  std::unique_ptr<Running> console_;
  std::optional<std::string> job_;
  std::string block_;  // as reported to be mounted
  std::uint16_t port_ = 0;
  std::string key_;
  int starts_ = 0;
};

}  // namespace intaglio::testing
