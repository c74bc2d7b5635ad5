// intaglio-console beside a shop of real processes: what it answers is what the command
// line prints, and its stop is judged by what the engraver recorded.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <regex>

#include "tests/integration/shop_floor.h"
#include "tests/services/platform/web/web_client.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using namespace intaglio::testing;
using test::Ask;
using test::WebAnswer;
using test::WebConnection;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kConsole[] = "intaglio-console";

/// Without the time of the answer, which differs.
std::string WithoutTime(const std::string& json) {
  static const std::regex kVaries("\"(time|free_bytes|lamp_warm_ratio)\": ?[^,\n]*,?");
  return std::regex_replace(json, kVaries, "");
}

class Console : public ::testing::Test {
 protected:
  static ShopFloor::Options OnABusOfItsOwn() {
    ShopFloor::Options options;
    options.bus = {"--domain", "46", "--tag", "console" + std::to_string(getpid())};
    return options;
  }
  void Open() {
    console_ = std::make_unique<Running>(
        Program(kConsole), floor_.With({"--address-file", address_file_.string()}),
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
        20s))
        << console_->Output();
  }
  WebAnswer Get(const std::string& path) const {
    return Ask(port_, {.path = path, .key = key_});
  }
  WebAnswer Post(const std::string& path, const std::string& body = "{}") const {
    return Ask(port_, {.method = "POST", .path = path, .key = key_, .body = body});
  }
  /// In mid-job, at a rate that leaves seconds of it, and known to the console.
  void EngraveSome() {
    floor_.StartAll();
    Open();
    job_ = floor_.Engrave({"--height", "4.2", "--spacing", "0.5", "--rate", "25"});
    ASSERT_TRUE(job_);
    ASSERT_TRUE(floor_.AwaitCracks(20, 40s)) << floor_.Logs();
    ASSERT_TRUE(
        Eventually([&] { return Job().find("engraving") != std::string::npos; }, 20s))
        << Job();
  }
  std::string Job() const { return Get("/api/v1/jobs/" + *job_).body; }
  void ExpectNothingFires() {
    const std::int64_t cracks = floor_.Panel("cracks");
    ASSERT_GE(cracks, 0);
    std::this_thread::sleep_for(3s);
    EXPECT_EQ(floor_.Panel("cracks"), cracks) << floor_.Logs();
  }

  fs::path folder_ = test::FreshFolder();
  fs::path address_file_ = folder_ / "console.address";
  ShopFloor floor_{folder_, OnABusOfItsOwn()};
  std::unique_ptr<Running> console_;
  std::optional<std::string> job_;
  std::uint16_t port_ = 0;
  std::string key_;
  int starts_ = 0;
};

TEST_F(Console, AnswersWhatTheCommandLinePrints) {
  EngraveSome();
  WebConnection events(port_);
  events.Send(
      fmt::format("GET /api/v1/events HTTP/1.1\r\nHost: localhost:{}\r\n"
                  "Authorization: Bearer {}\r\n\r\n",
                  port_, key_));
  EXPECT_THAT(events.ReadUntil("\r\n\r\n", 10s), HasSubstr("text/event-stream"));
  ASSERT_EQ(Post("/api/v1/jobs/" + *job_ + "/pause").status, 200);
  EXPECT_THAT(events.ReadUntil("\"state\":\"paused\"", 20s),
              HasSubstr("data: {\"time\":"));
  ASSERT_TRUE(floor_.Reaches("paused", 20s)) << floor_.Logs();
  const auto agrees = [&](const std::string& path,
                          const std::vector<std::string>& words) {
    std::string answered, printed;
    const bool same = Eventually(
        [&] {
          answered = WithoutTime(Get(path).body);
          printed = WithoutTime(floor_.Type(words).output);
          return answered == printed;
        },
        20s);
    EXPECT_TRUE(same) << path << "\n" << answered << "\n" << printed;
  };
  agrees("/api/v1/jobs", {"list", "--json"});
  agrees("/api/v1/jobs/" + *job_, {"show", *job_, "--json"});
  agrees("/api/v1/status", {"status", "--json"});
  EXPECT_EQ(Get("/api/v1/jobs/99").status, 404);
  EXPECT_EQ(Post("/api/v1/jobs/" + *job_ + "/arm").status, 404) << "no such command";
  // What was made is read from the job's folder, and grows when the job goes on.
  const WebAnswer plan = Get("/api/v1/jobs/" + *job_ + "/plan");
  ASSERT_EQ(plan.status, 200) << plan.body;
  EXPECT_EQ(plan.body.substr(0, 8), "INTPLAN1");
  EXPECT_GE(Get("/api/v1/jobs/" + *job_ + "/made").body.size(), 4u + 4 * 20);
  EXPECT_EQ(Get("/api/v1/jobs/" + *job_ + "/made?from=1000000").body.size(), 4u);
  EXPECT_EQ(Get("/api/v1/jobs/" + *job_ + "/made?from=x").status, 400);
  const std::int64_t cracks = floor_.Panel("cracks");
  const WebAnswer resumed = Post("/api/v1/jobs/" + *job_ + "/resume");
  EXPECT_EQ(resumed.status, 200) << resumed.body;
  EXPECT_TRUE(floor_.AwaitCracks(cracks + 5, 20s)) << floor_.Logs();
  const WebAnswer cancelled = Post("/api/v1/jobs/" + *job_ + "/cancel");
  EXPECT_EQ(cancelled.status, 200) << cancelled.body;
  ASSERT_TRUE(floor_.Reaches("cancelled", 20s)) << floor_.Logs();
  const WebAnswer again = Post("/api/v1/jobs/" + *job_ + "/pause");
  EXPECT_EQ(again.status, 409);
  EXPECT_THAT(again.body, HasSubstr("already cancelled"));
}

TEST_F(Console, StopsTheMachineWhenTheJobServiceIsDead) {
  EngraveSome();
  floor_.at(kJobService).Signal(SIGKILL);
  floor_.at(kJobService).WaitForEnd(5s);
  const WebAnswer stopped = Post("/api/v1/stop", R"({"reason": "smoke"})");
  EXPECT_EQ(stopped.status, 200);
  EXPECT_THAT(stopped.body, HasSubstr("\"cell\": \"els-03\",\n   \"confirmed\": true"));
  EXPECT_THAT(Get("/api/v1/status").body, HasSubstr("the emergency stop is pressed"));
  ExpectNothingFires();
  EXPECT_THAT(console_->Output(), Not(HasSubstr("error")));
}

TEST_F(Console, StopsByItsWebSocketAndNothingStartsOnReconnect) {
  EngraveSome();
  {
    WebConnection control(port_);
    control.Send(test::Upgrade(port_, "/control", key_));
    control.ReadUntil("\r\n\r\n", 10s);
    control.Send(test::Frame(R"({"stop": {"reason": "smoke"}})"));
    ASSERT_TRUE(Eventually(
        [&] {
          const auto text = test::ReadFrame(control, 5s);
          return text && text->find("\"sent\":true") != std::string::npos;
        },
        10s));
    ASSERT_TRUE(floor_.Reaches("paused", 20s)) << floor_.Logs();
    control.Send(test::Frame("{\"arm\": {}}"));
    control.Send(test::Frame("no json"));
  }
  for (int i = 0; i < 3; ++i) {
    WebConnection control(port_);
    control.Send(test::Upgrade(port_, "/control", key_));
    control.ReadUntil("\r\n\r\n", 10s);
    const auto state = test::ReadFrame(control, 10s);
    ASSERT_TRUE(state);
    EXPECT_THAT(*state, HasSubstr("\"stops_held\":[\"intaglio-console-"));
  }
  ExpectNothingFires();
  EXPECT_EQ(floor_.Newest("state"), "paused");
}

// Neither a reader nor a writer of the machine's messages is missed by the machine.
TEST_F(Console, ItsDeathInMidJobLosesNothing) {
  EngraveSome();
  const std::uint16_t port = port_;
  const std::string key = key_;
  console_->Signal(SIGKILL);
  console_->WaitForEnd(5s);
  Open();
  EXPECT_EQ(port_, port) << "an open page finds it again";
  EXPECT_EQ(key_, key);
  ASSERT_TRUE(floor_.Reaches("done", 90s)) << floor_.Logs();
  EXPECT_EQ(Get("/api/v1/jobs/" + *job_).status, 200);
  EXPECT_THAT(Job(), HasSubstr("\"missed\": 0"));
  EXPECT_THAT(Job(), HasSubstr("\"uncertain\": 0"));
  EXPECT_EQ(fs::status(address_file_).permissions() & fs::perms::mask,
            fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(Console, StrangersAndFloodsDoNotKeepAnAnswerBack) {
  floor_.StartAll();
  Open();
  ASSERT_TRUE(floor_.Opens());
  EXPECT_EQ(Ask(port_, {.path = "/api/v1/status"}).status, 401);
  EXPECT_EQ(Ask(port_, {.method = "POST",
                        .path = "/api/v1/stop",
                        .key = key_,
                        .headers = "Origin: http://evil.example\r\n"})
                .status,
            403);
  EXPECT_EQ(
      Ask(port_, {.path = "/api/v1/status", .key = key_, .host = "evil.example"}).status,
      421);
  EXPECT_EQ(Get("/../../../etc/passwd").status, 400);
  EXPECT_EQ(Get("/api/v1/jobs/..%2f..%2fetc%2fpasswd/plan").status, 400);
  EXPECT_EQ(Get("/etc/passwd").status, 404);
  std::vector<WebConnection> half_open;
  for (int i = 0; i < 200; ++i) {
    half_open.emplace_back(port_);
    half_open.back().Send("GET /api");
  }
  WebConnection slow(port_, 4096);
  slow.Send(test::Upgrade(port_, "/control", key_));
  std::vector<double> seconds;
  for (int i = 0; i < 20; ++i) {
    const WebAnswer answer = Get("/api/v1/status");
    ASSERT_EQ(answer.status, 200);
    seconds.push_back(answer.seconds);
  }
  std::nth_element(seconds.begin(), seconds.begin() + 10, seconds.end());
  RecordProperty("median_answer_ms", std::to_string(seconds[10] * 1000));
  EXPECT_LT(seconds[10], 0.2) << "on a busy computer";
  EXPECT_THAT(Ask(port_, {}).body, HasSubstr("stop-button"));
}

}  // namespace
}  // namespace intaglio
