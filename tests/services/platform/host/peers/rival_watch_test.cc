#include "services/platform/host/peers/rival_watch.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace intaglio::host {
namespace {

using namespace std::chrono_literals;
using Verdict = RivalWatch::Verdict;
constexpr auto kWatchPeriod = 250ms;

Rival Named(const std::string& name, intaglio_HealthState state) {
  return {name, "host", 1, state};
}

TEST(RivalWatch, WhoIsAloneGoesOnAfterOneWatchPeriod) {
  RivalWatch watch("b", 10s, kWatchPeriod);
  EXPECT_EQ(watch.JudgeStart(10s), Verdict::kWait);
  EXPECT_EQ(watch.JudgeStart(10s + 249ms), Verdict::kWait);
  EXPECT_EQ(watch.JudgeStart(10s + 250ms), Verdict::kGoOn);
}

TEST(RivalWatch, OnesOwnHealthIsNoRival) {
  RivalWatch watch("b", 0s, kWatchPeriod);
  for (const auto t : {0ms, 200ms, 400ms})
    watch.Receive(Named("b", intaglio_HEALTH_READY), t);
  EXPECT_EQ(watch.JudgeStart(400ms), Verdict::kGoOn);
}

// Whatever it is called.
TEST(RivalWatch, WhoWorksStays) {
  for (const std::string name : {"a", "c"}) {
    for (const auto state :
         {intaglio_HEALTH_READY, intaglio_HEALTH_BUSY, intaglio_HEALTH_FAULT}) {
      RivalWatch watch("b", 0s, kWatchPeriod);
      watch.Receive(Named(name, state), 10ms);
      EXPECT_EQ(watch.JudgeStart(10ms), Verdict::kWait) << "may be dead";
      watch.Receive(Named(name, state), 210ms);
      EXPECT_EQ(watch.JudgeStart(210ms), Verdict::kEnd);
      EXPECT_EQ(watch.rival().instance, name);
    }
  }
}

TEST(RivalWatch, OfTwoThatStartTheLesserNameStays) {
  RivalWatch a("a", 0s, kWatchPeriod), b("b", 0s, kWatchPeriod);
  for (const auto t : {10ms, 210ms}) {
    a.Receive(Named("b", intaglio_HEALTH_STARTING), t);
    b.Receive(Named("a", intaglio_HEALTH_STARTING), t);
  }
  EXPECT_EQ(a.JudgeStart(250ms), Verdict::kGoOn);
  EXPECT_EQ(b.JudgeStart(250ms), Verdict::kEnd);
}

// The last sample of a process that was killed stays until its lease is over.
TEST(RivalWatch, ADeadOneIsWaitedForAndNoLonger) {
  RivalWatch watch("b", 0s, kWatchPeriod);
  watch.Receive(Named("a", intaglio_HEALTH_BUSY), 10ms);
  EXPECT_EQ(watch.JudgeStart(1500ms), Verdict::kWait);
  EXPECT_EQ(watch.JudgeStart(1511ms), Verdict::kGoOn);
  RivalWatch reported("b", 0s, kWatchPeriod);
  reported.Receive(Named("a", intaglio_HEALTH_BUSY), 10ms);
  reported.Lose("a");
  EXPECT_EQ(reported.JudgeStart(250ms), Verdict::kGoOn);
}

TEST(RivalWatch, OneThatEndsIsWaitedFor) {
  RivalWatch watch("b", 0s, kWatchPeriod);
  watch.Receive(Named("a", intaglio_HEALTH_BUSY), 0ms);
  watch.Receive(Named("a", intaglio_HEALTH_STOPPING), 100ms);
  EXPECT_EQ(watch.JudgeStart(1000ms), Verdict::kWait);
  watch.Lose("a");
  EXPECT_EQ(watch.JudgeStart(1000ms), Verdict::kGoOn);
}

TEST(RivalWatch, OfTwoThatWorkTheLesserNameStays) {
  RivalWatch a("a", 0s, kWatchPeriod), b("b", 0s, kWatchPeriod);
  for (const auto t : {10s, 11s}) {
    a.Receive(Named("b", intaglio_HEALTH_READY), t);
    b.Receive(Named("a", intaglio_HEALTH_READY), t);
    b.Receive(Named("0", intaglio_HEALTH_STARTING), t);
  }
  EXPECT_EQ(a.JudgeWork(11s), Verdict::kGoOn);
  EXPECT_EQ(b.JudgeWork(11s), Verdict::kEnd);
  EXPECT_EQ(b.rival().instance, "a");
  EXPECT_EQ(b.JudgeWork(13s), Verdict::kGoOn) << "it is silent by now";
}

// Two processes that start `apart` from each other and receive each other from some
// moment on, each at its own: whatever the moments, one works in the end.
TEST(RivalWatch, OneStaysHoweverLateTheyReceiveEachOther) {
  struct Process {
    std::string name;
    std::chrono::milliseconds start, receives_from;
    std::optional<RivalWatch> watch = {};
    bool works = false, ended = false;
  };
  for (const auto apart : {0ms, 40ms, 120ms, 260ms, 700ms}) {
    for (const auto first_receives : {0ms, 100ms, 240ms, 300ms, 800ms}) {
      for (const auto second_receives : {0ms, 100ms, 240ms, 300ms, 800ms}) {
        for (const bool lesser_first : {false, true}) {
          std::vector<Process> two = {{lesser_first ? "a" : "b", 0ms, first_receives},
                                      {lesser_first ? "b" : "a", apart, second_receives}};
          for (auto t = 0ms; t < 4000ms; t += 10ms) {
            for (int i = 0; i < 2; ++i) {
              Process& self = two[i];
              const Process& other = two[1 - i];
              if (t < self.start || self.ended) continue;
              if (!self.watch) self.watch.emplace(self.name, t, kWatchPeriod);
              const bool reports =
                  other.watch && !other.ended && (t - other.start).count() % 200 == 0;
              if (reports &&
                  t >= self.receives_from + std::max(self.start, other.start)) {
                self.watch->Receive(
                    Named(other.name,
                          other.works ? intaglio_HEALTH_READY : intaglio_HEALTH_STARTING),
                    t);
              }
              const auto verdict =
                  self.works ? self.watch->JudgeWork(t) : self.watch->JudgeStart(t);
              self.ended = verdict == Verdict::kEnd;
              self.works = !self.ended && (self.works || verdict == Verdict::kGoOn);
            }
          }
          EXPECT_NE(two[0].works, two[1].works)
              << apart.count() << " " << first_receives.count() << " "
              << second_receives.count();
        }
      }
    }
  }
}

// The store of the queue has decided who goes on: the other one stands by.
TEST(RivalWatch, AStandbyIsNoRivalOfTheOwner) {
  RivalWatch watch("b", 0ms, kWatchPeriod, RivalWatch::Starting::kWaits);
  for (auto t = 0ms; t <= kWatchPeriod; t += 100ms)
    watch.Receive(Named("a", intaglio_HEALTH_STARTING), t);
  EXPECT_EQ(watch.JudgeStart(kWatchPeriod), Verdict::kGoOn);
  watch.Receive(Named("a", intaglio_HEALTH_READY), kWatchPeriod);
  EXPECT_EQ(watch.JudgeStart(kWatchPeriod), Verdict::kEnd) << "it works";
}

}  // namespace
}  // namespace intaglio::host
