// The job service's side of commands, with the bus and the database and without a queue.

#include "services/job_service/command_inbox.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <set>

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

TEST_F(CommandInboxTest, OneProcessThatFloodsDelaysItselfAlone) {
  bus::Bus flooding(test::PrivateBusOptions());
  bus::Writer<intaglio_JobCommand> flood(flooding, bus::kJobCommand);
  constexpr std::uint64_t kFlood = 3000;
  for (std::uint64_t i = 0; i < kFlood; ++i) {
    const std::string sender = fmt::format("a flooder {}", i);
    ASSERT_TRUE(flood.Write(Sample(sender, i, intaglio_COMMAND_PAUSE)));
  }
  std::size_t decided = 0;
  ASSERT_TRUE(test::Eventually([&] {
    const std::size_t now = Take().size();
    EXPECT_LE(now, CommandInbox::kDecidedATurn);
    decided += now;
    return decided > 100;
  }));
  Send("ann", 1, intaglio_COMMAND_ARM);
  Send("bob", 1, intaglio_COMMAND_PAUSE);
  const auto next = Take();
  EXPECT_THAT(next, testing::Contains("bob 1")) << "in the next turn";
  EXPECT_THAT(next, testing::Contains("ann 1")) << "though the flood is of pauses";
  decided += next.size();
  for (int turn = 0; turn < 200; ++turn) decided += Take().size();
  EXPECT_LE(decided, kFlood + 2);
  now_ += 1s;
  Take();
  std::set<std::string> left;
  const std::string end = "end of ";
  for (const std::string& answer : Answers()) {
    if (answer.starts_with(end))
      left.erase(answer.substr(end.size()));
    else
      left.insert(answer);
  }
  EXPECT_LE(left.size(), CommandInbox::kMaxAnswers + 2) << "on the bus";
}

// Nobody waits for an answer that does not come, and no flood takes the time of others.
TEST_F(CommandInboxTest, WhatIsDroppedIsAnsweredAndNamesTheProcess) {
  EXPECT_EQ(inbox_->Remark(now_), "");
  constexpr std::uint64_t kMore = WaitingCommands::kMaxOfProcess + 10;
  for (std::uint64_t i = 0; i < kMore; ++i) Send("ann", i);
  std::size_t decided = 0;
  std::map<intaglio_CommandAnswerCode, std::size_t> answers;
  std::string why;
  for (int turn = 0; turn < 100; ++turn) {
    decided += Take().size();
    answers_.Take([&](const intaglio_JobCommandAnswer& answer) {
      ++answers[answer.code];
      if (answer.code == intaglio_ANSWER_TOO_MANY) why = bus::View(answer.message);
    });
  }
  EXPECT_EQ(decided + answers[intaglio_ANSWER_TOO_MANY], kMore);
  EXPECT_EQ(answers[intaglio_ANSWER_TAKEN], decided);
  EXPECT_GE(answers[intaglio_ANSWER_TOO_MANY], 1u);
  EXPECT_THAT(why, testing::HasSubstr("end that process"));
  EXPECT_THAT(inbox_->Remark(now_), testing::HasSubstr(bus_.participant_name()));
  EXPECT_EQ(inbox_->Remark(now_ + CommandInbox::kFloodStays + 1s), "");
}

TEST(WaitingCommands, OfManyProcessesEachHasItsTurn) {
  WaitingCommands waiting;
  const auto command = [](const std::string& sender, std::uint64_t number,
                          intaglio_JobCommandKind kind = intaglio_COMMAND_ARM) {
    CommandView view;
    view.sender = sender;
    view.number = number;
    view.kind = kind;
    return view;
  };
  for (int process = 0; process < 5; ++process) {
    for (std::uint64_t i = 0; i < 3; ++i) {
      const std::string name = fmt::format("p{}", process);
      EXPECT_FALSE(waiting.Add(name, command(name, i)));
    }
  }
  std::map<std::string, int> taken;
  for (int turn = 0; turn < 5; ++turn) {
    const auto entries = waiting.TakeTurn(3);
    EXPECT_EQ(entries.size(), 3u);
    for (const auto& [process, one] : entries) {
      EXPECT_EQ(process, one.sender);
      ++taken[process];
    }
    int min_taken = 3, max_taken = 0;
    for (int process = 0; process < 5; ++process) {
      min_taken = std::min(min_taken, taken[fmt::format("p{}", process)]);
      max_taken = std::max(max_taken, taken[fmt::format("p{}", process)]);
    }
    EXPECT_LE(max_taken - min_taken, 1) << turn;
  }
  EXPECT_TRUE(waiting.TakeTurn(3).empty());

  // A full queue takes what stops in place of what does not, and nothing else.
  for (std::uint64_t i = 0; i < WaitingCommands::kMaxOfProcess; ++i)
    EXPECT_FALSE(waiting.Add("p", command("x", i)));
  EXPECT_FALSE(waiting.Add("p", command("x", 5))) << "delivered again, it still waits";
  const auto newest = waiting.Add("p", command("x", 9999));
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->number, 9999u);
  EXPECT_FALSE(waiting.Add("q", command("y", 1)));
  const auto last = waiting.Add("p", command("x", 9999, intaglio_COMMAND_PAUSE));
  ASSERT_TRUE(last) << "the one that gives its place is answered, too";
  EXPECT_EQ(last->number, WaitingCommands::kMaxOfProcess - 1);
  const auto first = waiting.TakeTurn(1);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].command.number, 9999u);
}

}  // namespace
}  // namespace intaglio::job_service
