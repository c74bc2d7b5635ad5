#include "services/client/shop/shop_status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/cli/status/status_text.h"
#include "tests/services/cli/status/shown_job.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;
using client::CellSnapshot;
using client::ShopSnapshot;
using client::StatusOf;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

client::ServiceView Service(intaglio_ServiceRole role, const std::string& cell = "") {
  client::ServiceView service;
  service.instance = "s" + std::to_string(static_cast<int>(role)) + cell;
  service.role = role;
  service.cell = cell;
  service.state = intaglio_HEALTH_READY;
  service.version = "0.2.0";
  return service;
}

/// A shop with one machine and nothing to do.
ShopSnapshot GoodShop() {
  ShopSnapshot shop;
  shop.services = {Service(intaglio_ROLE_JOB_SERVICE), Service(intaglio_ROLE_DISCRETIZER),
                   Service(intaglio_ROLE_SORTER),
                   Service(intaglio_ROLE_SYNCHRONIZER, "left"),
                   Service(intaglio_ROLE_MOTION_BRIDGE, "left")};
  CellSnapshot& cell = shop.cells["left"];
  cell.has_interlock = cell.laser_line_up = cell.key_on = cell.door_closed = true;
  cell.stop_released = cell.lamp_on = cell.lamp_warm = cell.has_motion = true;
  shop.disks = {{"s0", "/shop", 5'000'000'000, 20'000'000'000}};
  return shop;
}

ShopStatus Status(const ShopSnapshot& shop) {
  return StatusOf(shop, std::chrono::system_clock::time_point{});
}

/// That a person is needed, for this and nothing else.
void ExpectNeed(const ShopSnapshot& shop, const std::string& why) {
  const ShopStatus status = Status(shop);
  EXPECT_TRUE(status.needs_person()) << why;
  ASSERT_EQ(status.needs_size(), 1) << TextOf(status);
  EXPECT_THAT(status.needs(0), HasSubstr(why));
  EXPECT_THAT(TextOf(status), HasSubstr("NEEDS A PERSON"));
  EXPECT_THAT(TextOf(status), HasSubstr("to do      "));
}

TEST(ShopStatus, AServiceOfAnotherVersionIsNamedWithBoth) {
  ShopSnapshot shop = GoodShop();
  shop.services[3].version = "0.1.9";
  shop.services[3].host = "mill-room";
  // Nor is its machine's state understood: nobody is sent to look for a cable.
  shop.cells["left"] = {};
  ExpectNeed(shop, shop.services[3].instance +
                       " on mill-room has version 0.1.9, the job service 0.2.0: restart");
  EXPECT_TRUE(Status(shop).machines(0).other_version());
  EXPECT_FALSE(Status(GoodShop()).machines(0).other_version());
  const std::string text = TextOf(Status(shop));
  EXPECT_THAT(text, HasSubstr("OTHER VERSION"));
  EXPECT_THAT(text, Not(HasSubstr("DOWN")));
}

TEST(ShopStatus, AllIsWellInAShopThatWaitsForJobs) {
  const ShopStatus status = Status(GoodShop());
  EXPECT_FALSE(status.needs_person()) << TextOf(status);
  const std::string text = TextOf(status);
  EXPECT_THAT(text, HasSubstr("all is well"));
  EXPECT_THAT(text, HasSubstr("lamp warm, key on, door closed, stop released, no job"));
  EXPECT_THAT(text, HasSubstr("5.0 GB of 20.0 GB free  /shop"));
  EXPECT_THAT(text, Not(HasSubstr("to do")));
}

TEST(ShopStatus, AMissingServiceNeedsAPerson) {
  for (const std::size_t index : {0u, 1u, 2u, 3u, 4u}) {
    ShopSnapshot shop = GoodShop();
    shop.services.erase(shop.services.begin() + index);
    const char* names[] = {"job-service", "discretizer", "sorter", "synchronizer",
                           "motion-bridge"};
    ExpectNeed(shop, std::string("no ") + names[index] + " runs");
  }
}

TEST(ShopStatus, AFaultAndAWarningOfAServiceAreAlarms) {
  ShopSnapshot shop = GoodShop();
  shop.services[0].state = intaglio_HEALTH_FAULT;
  shop.services[0].message = "the disk is full";
  ExpectNeed(shop, "job-service: the disk is full");
  shop = GoodShop();
  shop.services[4].message = "the position tolerance differs";
  ExpectNeed(shop, "motion-bridge of left: the position tolerance differs");
}

TEST(ShopStatus, AStopNeedsAPersonAndIsNamed) {
  ShopSnapshot shop = GoodShop();
  shop.cells["left"].stop_pressed = true;
  shop.cells["left"].stops_held = {{"ann", 1}, {"bob", 2}};
  ExpectNeed(shop, "the emergency stop is pressed (ann (number 1), bob (number 2))");
  EXPECT_THAT(TextOf(Status(shop)), HasSubstr("STOP PRESSED by ann (number 1)"));
}

// Which of the three is open is known only where they are three inputs.
TEST(ShopStatus, AnOpenChainNamesNoSingleContact) {
  ShopSnapshot shop = GoodShop();
  CellSnapshot& cell = shop.cells["left"];
  cell.key_on = cell.door_closed = cell.stop_released = false;
  EXPECT_THAT(TextOf(Status(shop)),
              AllOf(HasSubstr("KEY, DOOR OR STOP OPEN"), Not(HasSubstr("KEY OFF"))));
  cell.key_on = true;
  EXPECT_THAT(TextOf(Status(shop)), AllOf(HasSubstr("key on"), HasSubstr("DOOR OPEN")));
}

TEST(ShopStatus, StatesItsAgeAndAServiceThatIsSilentNeedsAPerson) {
  ShopSnapshot shop = GoodShop();
  shop.taken_at += 700ms;  // since all services have reported
  EXPECT_THAT(TextOf(Status(shop)), HasSubstr("all is well, machines as of 0.7 s ago"));
  EXPECT_NEAR(Status(shop).machines(0).age_s(), 0.7, 1e-9);
  shop.taken_at += 7s;
  shop.services[3].reported_at += 7s;  // the synchronizer; the bridge is silent
  shop.services[4].reported_at -= 300ms;
  ExpectNeed(shop, "left: a service of it has reported nothing for 8 s");
  EXPECT_THAT(TextOf(Status(shop)), HasSubstr("left       AS IT WAS 8 s AGO, lamp warm"));
}

TEST(ShopStatus, LinesThatAreDownNeedAPerson) {
  ShopSnapshot shop = GoodShop();
  shop.cells["left"].laser_line_up = false;
  ExpectNeed(shop, "left: the laser does not answer");
  EXPECT_THAT(TextOf(Status(shop)), HasSubstr("LASER LINE DOWN"));
  shop = GoodShop();
  shop.cells["left"].motion_fault = intaglio_MOTION_LINK_LOST;
  ExpectNeed(shop, "left: the stage does not answer");
}

TEST(ShopStatus, TheMachinesOwnStopNeedsAPersonOnlyWhileTheMachineHasAJob) {
  ShopSnapshot shop = GoodShop();
  shop.cells["left"].stop_released = false;
  EXPECT_FALSE(Status(shop).needs_person());
  shop.jobs = {ShownJob(3, intaglio_JOB_ENGRAVING)};
  ExpectNeed(shop, "left: the machine's own emergency stop is pressed or latched");
}

TEST(ShopStatus, AJobThatNeedsAConsentNeedsAPerson) {
  ShopSnapshot shop = GoodShop();
  shop.jobs = {ShownJob(3, intaglio_JOB_SORTING)};
  shop.jobs[0].warnings = {MakeWarning(WarningCode::kBreakage, "the glass may break")};
  ExpectNeed(shop,
             "job 3 needs a consent: the glass may break (intaglio arm 3 "
             "--accept breakage, or cancel)");
  shop.jobs[0].breakage_accepted_by = "ann";
  EXPECT_FALSE(Status(shop).needs_person());
}

TEST(ShopStatus, UncertainPointsAreNamedWithBothCommandsBeforeAnybodyResumes) {
  ShopSnapshot shop = GoodShop();
  shop.jobs = {ShownJob(3, intaglio_JOB_PAUSED)};
  shop.jobs[0].message = "the power was off";
  shop.jobs[0].counts = {100, 40, 0, 0, 3, 57, 0};
  ExpectNeed(
      shop,
      "job 3 is paused: the power was off; of 3 points it is not known whether they "
      "were fired: check the block, then intaglio resume 3 to leave them as they "
      "are, or intaglio resume 3 --fire-uncertain to fire them again");
  shop.jobs[0].makes = "marks";
  ExpectNeed(
      shop,
      "job 3 is paused: the power was off; of 3 marks it is not known whether they "
      "were made to their end: check the piece, then intaglio resume 3 to leave them as "
      "they are, or intaglio resume 3 --fire-uncertain to make them again");
}

/// With a mill in place of the machine: a marker, one line, no bridge and no lamp.
ShopSnapshot MillShop() {
  ShopSnapshot shop = GoodShop();
  shop.services.resize(3);
  client::ServiceView marker = Service(intaglio_ROLE_SYNCHRONIZER, "mill");
  marker.instance = "marker-host-7-0110";
  shop.services.push_back(marker);
  CellSnapshot cell = shop.cells["left"];
  cell.lamp_on = cell.lamp_warm = cell.has_motion = false;
  shop.cells = {{"mill", cell}};
  return shop;
}

TEST(ShopStatus, AMachineOfOneLineNeedsNeitherABridgeNorALamp) {
  const ShopStatus status = Status(MillShop());
  EXPECT_FALSE(status.needs_person()) << TextOf(status);
  EXPECT_EQ(status.services(3).role(), "marker");
  EXPECT_TRUE(status.machines(0).one_line());
  EXPECT_TRUE(status.machines(0).motion_line_up()) << "it is idle, and not unknown";
  EXPECT_EQ(status.machines(0).lamp(), "none");
  EXPECT_THAT(TextOf(status),
              HasSubstr("mill       key on, door closed, stop released, no job"));
}

TEST(ShopStatus, AMachineOfOneLineThatDoesNotAnswerIsNamedOnce) {
  ShopSnapshot shop = MillShop();
  shop.cells["mill"].laser_line_up = false;
  ExpectNeed(shop, "mill: the controller does not answer: check its cable");
  EXPECT_THAT(TextOf(Status(shop)), HasSubstr("mill       LINE DOWN, no job"));
}

TEST(ShopStatus, ShowsAnOpenInputAndTheOutputsThatAreOn) {
  ShopSnapshot shop = GoodShop();
  shop.cells["left"].open_input = "the input 'clamp' is off: close the clamp";
  shop.cells["left"].outputs_on = "air, extraction";
  EXPECT_THAT(TextOf(Status(shop)),
              HasSubstr("stop released, the input 'clamp' is off: close the clamp, on: "
                        "air, extraction, no job"));
}

// Somebody changes the block.
TEST(ShopStatus, AnOpenDoorNeedsAPersonOnlyWhileTheMachineHasAJob) {
  ShopSnapshot shop = GoodShop();
  shop.cells["left"].door_closed = false;
  EXPECT_FALSE(Status(shop).needs_person());
  EXPECT_THAT(TextOf(Status(shop)), HasSubstr("DOOR OPEN"));
  shop.jobs = {ShownJob(3, intaglio_JOB_ENGRAVING)};
  ExpectNeed(shop, "left: the door is open");
  shop.cells["left"].door_closed = true;
  shop.cells["left"].open_input = "the input 'clamp' is off: close the clamp";
  ExpectNeed(shop, "left: the input 'clamp' is off: close the clamp");
  EXPECT_EQ(Status(shop).machines(0).job(), 3u);
}

TEST(ShopStatus, JobsThatWaitForAPerson) {
  ShopSnapshot shop = GoodShop();
  shop.jobs = {ShownJob(3, intaglio_JOB_PAUSED)};
  shop.jobs[0].message = "the door was opened";
  ExpectNeed(shop, "job 3 is paused: the door was opened (intaglio resume 3, or cancel)");
  shop.jobs[0].armed = true;  // it goes on by itself
  EXPECT_FALSE(Status(shop).needs_person());
  shop.jobs = {ShownJob(3, intaglio_JOB_WAITING_FOR_ARM)};
  ExpectNeed(shop, "job 3 waits for its arm");
  shop.jobs = {ShownJob(3, intaglio_JOB_ENGRAVING)};
  shop.jobs[0].alarm = "no progress: 3 of 2400 expected points";
  ExpectNeed(shop, "job 3: no progress: 3 of 2400");
}

TEST(ShopStatus, JobsWithTheirProgressAndTheCountOfEndedOnes) {
  ShopSnapshot shop = GoodShop();
  shop.jobs = {ShownJob(2, intaglio_JOB_DONE), ShownJob(3, intaglio_JOB_ENGRAVING),
               ShownJob(4, intaglio_JOB_QUEUED)};
  shop.jobs[1].progress = {{intaglio_STAGE_ENGRAVE, 1200, 5000, 10}};
  shop.jobs[1].counts = {5000, 1190, 10, 0, 0, 3797, 3};
  shop.jobs[2].message = "waits for its turn on left";
  const ShopStatus status = Status(shop);
  EXPECT_FALSE(status.needs_person());
  EXPECT_EQ(status.ended_jobs(), 1u);
  ASSERT_EQ(status.jobs_size(), 2);
  EXPECT_EQ(status.jobs(0).state(), "engraving");
  EXPECT_EQ(status.jobs(0).missed(), 10u);
  EXPECT_EQ(status.jobs(0).skipped(), 0u) << "they are to come";
  EXPECT_EQ(status.jobs(0).to_come(), 3797u);
  EXPECT_EQ(status.jobs(0).armed_count(), 3u);
  const std::string text = TextOf(status);
  EXPECT_THAT(text, HasSubstr("jobs       2 open, 1 ended"));
  EXPECT_THAT(text, HasSubstr("engrave 1 200 / 5 000"));
  EXPECT_THAT(text, HasSubstr("waits for its turn on left"));
}

// 1200 of 5000 in 100 s: 3800 at that pace take 316.7 s.
TEST(ShopStatus, AJobAtWorkHasItsShareTheTimeLeftAndTheClockTimeOfItsEnd) {
  setenv("TZ", "UTC", 1);
  tzset();
  ShopSnapshot shop = GoodShop();
  shop.jobs = {ShownJob(3, intaglio_JOB_ENGRAVING)};
  shop.jobs[0].progress = {{intaglio_STAGE_ENGRAVE, 1200, 5000, 100}};
  const auto now =
      std::chrono::system_clock::time_point(std::chrono::seconds(1'790'000'000));
  const ShopStatus status = client::StatusOf(shop, now);
  EXPECT_DOUBLE_EQ(status.jobs(0).progress_ratio(), 0.24);
  EXPECT_NEAR(status.jobs(0).left_s(), 316.67, 0.01);
  EXPECT_EQ(status.jobs(0).ends_utc(), "2026-09-21T14:18:36.667Z");
  EXPECT_THAT(TextOf(status, 1'790'000'000),
              HasSubstr("24 %, 5 min 17 s left, ends 14:18"));
  shop.jobs[0].state = intaglio_JOB_PAUSED;
  const ShopStatus paused = client::StatusOf(shop, now);
  EXPECT_EQ(paused.jobs(0).left_s(), 0) << "it is not known";
  EXPECT_EQ(paused.jobs(0).ends_utc(), "");
  EXPECT_THAT(TextOf(paused), Not(HasSubstr("s left")));
}

TEST(ShopStatus, ADiskThatIsNearlyFull) {
  ShopSnapshot shop = GoodShop();
  shop.disks[0].free_bytes = 50'000'000;
  ExpectNeed(shop, "the disk of /shop is nearly full, 50.0 MB are free");
  EXPECT_TRUE(Status(shop).disks(0).low());
}

TEST(ShopStatus, ALampThatWarmsUpNeedsNobody) {
  ShopSnapshot shop = GoodShop();
  shop.cells["left"].lamp_warm = false;
  shop.cells["left"].warm_ratio = 0.25;
  EXPECT_FALSE(Status(shop).needs_person());
  EXPECT_THAT(TextOf(Status(shop)), HasSubstr("lamp warms up (25 %)"));
}

// In the words of `list` and `show`; programs read the name of the state.
TEST(ShopStatus, AJobHasItsStateForPeopleAndTheSpeedThatWasSet) {
  ShopSnapshot shop = GoodShop();
  shop.jobs = {ShownJob(3, intaglio_JOB_WAITING_FOR_ARM)};
  EXPECT_EQ(Status(shop).jobs(0).state(), "waiting_for_arm");
  EXPECT_THAT(TextOf(Status(shop)), HasSubstr("     3  waiting for arm "));
  shop.jobs[0].armed = true;
  shop.jobs[0].speed_percent = 50;
  shop.jobs[0].message = "the lamp warms up: 17 %";
  EXPECT_EQ(Status(shop).jobs(0).speed_percent(), 50u);
  EXPECT_THAT(TextOf(Status(shop)),
              AllOf(HasSubstr("     3  armed, the lamp warms up left"),
                    HasSubstr("        at 50 % speed\n")));
}

}  // namespace
}  // namespace intaglio::cli
