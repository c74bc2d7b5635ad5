// intaglio-console beside a shop of real processes: what it answers is what the command
// line prints, and its stop is judged by what the engraver recorded.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <regex>

#include "tests/integration/console_shop.h"

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

/// Without the time of the answer and those that follow from it, which differ.
std::string WithoutTime(const std::string& json) {
  static const std::regex kVaries(
      "\"(time|ends_utc|free_bytes|lamp_warm_ratio|age_s)\": ?[^,\n]*,?");
  return std::regex_replace(json, kVaries, "");
}

class Console : public ConsoleShop {};

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
  EXPECT_EQ(Post("/api/v1/jobs/" + *job_ + "/light").status, 404) << "no such command";
  const WebAnswer unknown = Post("/api/v1/jobs/99/cancel");
  EXPECT_EQ(unknown.status, 404);
  EXPECT_THAT(unknown.body, HasSubstr("\"code\": \"not_found\""));
  // What was made is read from the job's folder, and grows when the job goes on.
  const WebAnswer plan = Get("/api/v1/jobs/" + *job_ + "/plan");
  ASSERT_EQ(plan.status, 200) << plan.body;
  EXPECT_EQ(plan.body.substr(0, 8), "INTPLAN2");
  EXPECT_GE(Get("/api/v1/jobs/" + *job_ + "/made").body.size(), 4u + 4 * 20);
  EXPECT_EQ(Get("/api/v1/jobs/" + *job_ + "/made?from=1000000").body.size(), 4u);
  EXPECT_EQ(Get("/api/v1/jobs/" + *job_ + "/made?from=x").status, 400);
  const std::int64_t cracks = floor_.Panel("cracks");
  EXPECT_THAT(Post("/api/v1/jobs/" + *job_ + "/resume").body, HasSubstr("not_held"));
  EXPECT_EQ(floor_.Type({"resume", *job_}).exit_code, 0) << floor_.Logs();
  EXPECT_TRUE(floor_.AwaitCracks(cracks + 5, 20s)) << floor_.Logs();
  const WebAnswer cancelled = Post("/api/v1/jobs/" + *job_ + "/cancel");
  EXPECT_EQ(cancelled.status, 200) << cancelled.body;
  ASSERT_TRUE(floor_.Reaches("cancelled", 20s)) << floor_.Logs();
  const WebAnswer again = Post("/api/v1/jobs/" + *job_ + "/pause");
  EXPECT_EQ(again.status, 409);
  EXPECT_THAT(again.body, HasSubstr("already cancelled"));
  const WebAnswer metrics = Get("/metrics");
  EXPECT_EQ(metrics.status, 200);
  EXPECT_THAT(metrics.headers, HasSubstr("version=0.0.4"));
  EXPECT_THAT(metrics.body, HasSubstr("{machine=\"els-03\",use=\"engraving\"} "));
  EXPECT_THAT(metrics.body, HasSubstr("{machine=\"els-03\",use=\"paused_operator\"} "));
  EXPECT_TRUE(Eventually(
      [&] {
        return Get("/metrics").body.find("intaglio_pieces_total{machine=\"els-03\"") !=
               std::string::npos;
      },
      20s));
  // The results of its folder, and nothing else that is there.
  const std::string job = "/api/v1/jobs/" + *job_;
  EXPECT_EQ(Get(job + "/report").status, 404) << "no proofs are made here";
  std::smatch folder;
  const std::string record = Job();
  ASSERT_TRUE(std::regex_search(record, folder,
                                std::regex("\"result_directory\": \"([^\"]+)\"")));
  const std::string report = "{\"name\": \"<script>\"}";
  std::ofstream(fs::path(folder[1].str()) / "report.json") << report;
  const WebAnswer read = Get(job + "/report");
  EXPECT_EQ(read.status, 200);
  EXPECT_EQ(read.body, report);
  EXPECT_THAT(read.headers, HasSubstr("application/json"));
  ASSERT_TRUE(fs::exists(fs::path(folder[1].str()) / "journal.bin"));
  EXPECT_EQ(Get(job + "/journal.bin").status, 404);
  EXPECT_EQ(Get(job + "/report.json").status, 404);
  EXPECT_EQ(Get(job + "/..%2freport").status, 400);
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

TEST_F(Console, ArmsByAPressThatIsHeldAndByNothingElse) {
  AwaitArm();
  ExpectRefused(PostToJob("arm"), "not_held");
  ExpectRefused(Press("60 x 30 x 20 N-BK7"), "other_block");
  EXPECT_EQ(PostToJob("arm", R"({"armed": true})").status, 400);
  ExpectRefused(PostToJob("arm", Press()), "not_held");  // too early
  const std::string used_early = Press();
  ExpectRefused(PostToJob("arm", used_early), "not_held");
  std::this_thread::sleep_for(1300ms);
  ExpectRefused(PostToJob("arm", used_early), "not_held");
  const std::string late = Press();
  std::this_thread::sleep_for(3500ms);
  ExpectRefused(PostToJob("arm", late), "not_held");
  const std::string of_a_dead_console = Press();
  console_->Signal(SIGKILL);
  console_->WaitForEnd(5s);
  Open();
  ASSERT_TRUE(StatusShows(block_));
  ASSERT_TRUE(JobShows("waiting_for_arm"));
  ExpectRefused(PostToJob("arm", of_a_dead_console), "not_held");
  ExpectNothingFires();
  EXPECT_EQ(floor_.Panel("cracks"), 0);
  const std::string held = Press();
  std::this_thread::sleep_for(1300ms);
  const WebAnswer armed = PostToJob("arm", held);
  EXPECT_EQ(armed.status, 200) << armed.body;
  ASSERT_TRUE(floor_.AwaitCracks(5, 40s)) << floor_.Logs();
  // What was paused does not go on by messages that come again.
  ASSERT_EQ(PostToJob("pause").status, 200);
  ASSERT_TRUE(JobShows("\"paused\""));
  ExpectRefused(PostToJob("arm", held), "not_held");
  ExpectRefused(PostToJob("resume", held), "not_held");
  ExpectNothingFires();
  EXPECT_EQ(PostToJob("speed", R"({"percent": 50})").status, 200);
  EXPECT_TRUE(JobShows("\"speed_percent\": 50"));
  ExpectRefused(PostToJob("speed", R"({"percent": 0})"), "out_of_range");
  ExpectRefused(PostToJob("move", R"({"before": ""})"), "out_of_range");
  const std::int64_t cracks = floor_.Panel("cracks");
  const std::string again = Press();
  std::this_thread::sleep_for(1300ms);
  EXPECT_EQ(PostToJob("resume", again).status, 200);
  EXPECT_TRUE(floor_.AwaitCracks(cracks + 3, 20s)) << floor_.Logs();
}

TEST_F(Console, ArmsNothingAtAnOpenDoorOrAfterAPause) {
  AwaitArm();
  AskPanel(floor_.folder(), "door open");
  ASSERT_TRUE(StatusShows("\"door_closed\": false"));
  ExpectRefused(Press(block_), "door_open");
  AskPanel(floor_.folder(), "door close");
  ASSERT_TRUE(StatusShows("\"door_closed\": true"));
  // It opens while the button is held.
  const std::string held = Press();
  AskPanel(floor_.folder(), "door open");
  std::this_thread::sleep_for(1300ms);
  ExpectRefused(PostToJob("arm", held), "door_open");
  AskPanel(floor_.folder(), "door close");
  ASSERT_TRUE(StatusShows("\"door_closed\": true"));
  // Somebody pauses it meanwhile.
  const std::string paused_meanwhile = Press();
  EXPECT_EQ(PostToJob("pause").status, 200);
  std::this_thread::sleep_for(1300ms);
  ExpectRefused(PostToJob("arm", paused_meanwhile), "superseded");
  // Somebody changes the block meanwhile.
  const std::string other_block = Press();
  const Ended mounted = floor_.Type({"mount", "--block", "60", "60", "30"});
  ASSERT_EQ(mounted.exit_code, 0) << mounted.output;
  ASSERT_TRUE(StatusShows("60 x 60 x 30"));
  ExpectRefused(PostToJob("arm", other_block), "not_held");
  ExpectNothingFires();
  EXPECT_EQ(floor_.Panel("cracks"), 0);
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
