// The job service's side of commands, with the bus and the database and without a queue.

#include "services/job_service/command_inbox.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

class CommandInboxTest : public testing::Test {
 protected:
  CommandInboxTest() {
    answers_.Take([](const intaglio_JobCommandAnswer&) {});
    NextLife();
  }
  /// The job service is started again.
  void NextLife() {
    inbox_.reset();
    store_.emplace(folder_ / "jobs.db");
    inbox_.emplace(bus_, *store_);
  }
  intaglio_JobCommand Sample(const std::string& sender, std::uint64_t number,
                             intaglio_JobCommandKind kind = intaglio_COMMAND_ARM) {
    intaglio_JobCommand sample{};
    sample.sender = bus::Borrow(sender);
    sample.number = number;
    sample.kind = kind;
    sample.job_uid = bus::Borrow(uid_);
    sample.operator_name = bus::Borrow(uid_);
    return sample;
  }
  void Send(const std::string& sender, std::uint64_t number,
            intaglio_JobCommandKind kind = intaglio_COMMAND_ARM) {
    EXPECT_TRUE(commands_.Write(Sample(sender, number, kind)));
  }
  void End(const std::string& sender, std::uint64_t number) {
    EXPECT_TRUE(commands_.Dispose(Sample(sender, number)));
  }
  /// What was decided on in one Take, in that order.
  std::vector<std::string> Take() {
    std::vector<std::string> decided;
    inbox_->Take(
        [&](const CommandView& command) {
          decided.push_back(fmt::format("{} {}", command.sender, command.number));
          return CommandAnswer{};
        },
        now_);
    return decided;
  }
  /// The answers that are there: sender and number, and those that ended.
  std::vector<std::string> Answers() {
    std::vector<std::string> seen;
    answers_.TakeAll(
        [&](const intaglio_JobCommandAnswer& answer, const bus::SampleOrigin& origin) {
          seen.push_back(fmt::format("{}{} {}", origin.alive ? "" : "end of ",
                                     bus::View(answer.sender), answer.number));
        });
    return seen;
  }

  const std::string uid_ = "1-abc";
  std::filesystem::path folder_ = test::FreshFolder();
  Nanoseconds now_{100s};
  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_JobCommand> commands_{bus_, bus::kJobCommand};
  bus::Reader<intaglio_JobCommandAnswer> answers_{bus_, bus::kJobCommandAnswer};
  std::optional<JobStore> store_;
  std::optional<CommandInbox> inbox_;
};

TEST_F(CommandInboxTest, EveryCommandIsAnsweredAndNoneTakesTheOthersPlace) {
  Send("ann", 1);
  Send("bob", 1);
  Send("ann", 2);
  EXPECT_THAT(Take(), ElementsAre("ann 1", "ann 2", "bob 1"));
  EXPECT_THAT(Answers(), UnorderedElementsAre("ann 1", "ann 2", "bob 1"));
}

TEST_F(CommandInboxTest, PauseAndCancelAreDecidedFirst) {
  Send("ann", 1, intaglio_COMMAND_ARM);
  Send("ann", 2, intaglio_COMMAND_RESUME);
  Send("bob", 1, intaglio_COMMAND_PAUSE);
  Send("bob", 2, intaglio_COMMAND_CANCEL);
  EXPECT_THAT(Take(), ElementsAre("bob 1", "bob 2", "ann 1", "ann 2"));
}

// On a network that has two programs find each other at different times.
TEST_F(CommandInboxTest, AClientThatFindsTheAnswersLateGetsItsOwn) {
  Send("ann", 1);
  EXPECT_THAT(Take(), ElementsAre("ann 1"));
  bus::Bus late_bus(test::PrivateBusOptions());
  bus::Reader<intaglio_JobCommandAnswer> late(late_bus, bus::kJobCommandAnswer);
  int received = 0;
  EXPECT_TRUE(test::Eventually([&] {
    late.Take([&](const intaglio_JobCommandAnswer& answer) {
      received += bus::View(answer.sender) == "ann" && answer.number == 1 ? 1 : 0;
    });
    return received == 1;
  }));
}

// Delivered again because its client lives; the database knows it.
TEST_F(CommandInboxTest, TheNextLifeAnswersAgainAndDecidesNothing) {
  Send("ann", 1);
  EXPECT_THAT(Take(), ElementsAre("ann 1"));
  Answers();
  NextLife();
  EXPECT_THAT(Take(), ElementsAre());
  EXPECT_THAT(Answers(), testing::Contains("ann 1"));
}

// The client has reported to a person that there was no answer.
TEST_F(CommandInboxTest, WhatWasWithdrawnBeforeItWasReadArmsNothing) {
  Send("ann", 1, intaglio_COMMAND_ARM);
  End("ann", 1);
  Send("ann", 2, intaglio_COMMAND_PAUSE);
  End("ann", 2);
  Send("ann", 3, intaglio_COMMAND_ARM);
  EXPECT_THAT(Take(), ElementsAre("ann 2", "ann 3"));
}

TEST_F(CommandInboxTest, AnswersAreDisposedAfterAWhile) {
  Send("ann", 1);
  Take();
  now_ += 30s;
  Send("bob", 1);
  Take();
  EXPECT_THAT(Answers(), UnorderedElementsAre("ann 1", "bob 1"));
  now_ += 31s;
  Take();
  EXPECT_THAT(Answers(), ElementsAre("end of ann 1"));
}

}  // namespace
}  // namespace intaglio::job_service
