#include "services/platform/host/safety/stop_latch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <utility>

#include "services/platform/bus/samples.h"

namespace intaglio::host {
namespace {

using Presses = std::vector<StopPress>;

/// An EmergencyStop with its own storage.
struct Sample {
  std::string source;
  std::uint64_t number = 1;
  bool pressed = true;
  Presses released = {};

  bool GiveTo(StopLatch& latch) const {
    const auto wire = WireOf(released);
    intaglio_EmergencyStop sample{};
    sample.source = bus::Borrow(source);
    sample.number = number;
    sample.pressed = pressed;
    bus::Borrow(sample.released, wire);
    return latch.Receive(sample);
  }
};

Sample PressOf(const std::string& source, std::uint64_t number) {
  return {source, number, true, {}};
}
Sample ResetOf(Presses released) { return {"reset", 1, false, std::move(released)}; }

TEST(StopLatch, IsReleasedOnlyByAResetThatNamesThePress) {
  StopLatch stop;
  EXPECT_FALSE(stop.pressed());
  EXPECT_TRUE(PressOf("ann", 5).GiveTo(stop));
  EXPECT_FALSE(PressOf("ann", 5).GiveTo(stop)) << "repeated";
  for (const Presses& other : std::vector<Presses>{
           {}, {{"ann", 4}}, {{"bob", std::numeric_limits<std::uint64_t>::max()}}}) {
    ResetOf(other).GiveTo(stop);
    EXPECT_TRUE(stop.pressed());
  }
  ResetOf({{"ann", 5}}).GiveTo(stop);
  EXPECT_FALSE(stop.pressed());
  EXPECT_TRUE(PressOf("ann", 6).GiveTo(stop)) << "a greater number always latches";
  EXPECT_EQ(stop.held(), (Presses{{"ann", 6}}));
}

// Two senders that do not know of each other: in the past the greater number of the reset
// released both.
TEST(StopLatch, AResetLeavesAPressThatItsSenderHadNotReceived) {
  StopLatch stop;
  PressOf("ann", 1).GiveTo(stop);
  PressOf("bob", 1).GiveTo(stop);
  ResetOf({{"ann", 1}}).GiveTo(stop);
  EXPECT_EQ(stop.held(), (Presses{{"bob", 1}}));
  ResetOf({{"ann", 1}, {"bob", 1}}).GiveTo(stop);
  EXPECT_FALSE(stop.pressed());
}

TEST(StopLatch, APressWithAListReleasesNothing) {
  StopLatch stop;
  PressOf("ann", 1).GiveTo(stop);
  Sample{"bob", 1, true, {{"ann", 1}}}.GiveTo(stop);
  EXPECT_EQ(stop.held().size(), 2u);
}

TEST(StopLatch, AResetThatComesFirstStopsOnceAndVoidsItsPress) {
  StopLatch stop;
  EXPECT_TRUE(ResetOf({{"ann", 3}}).GiveTo(stop)) << "it shows that there was a press";
  EXPECT_FALSE(stop.pressed());
  EXPECT_FALSE(PressOf("ann", 3).GiveTo(stop));
  EXPECT_FALSE(stop.pressed());
  EXPECT_TRUE(PressOf("ann", 4).GiveTo(stop));
  EXPECT_TRUE(stop.pressed());
}

TEST(StopLatch, NumberZeroIsAPressToo) {
  StopLatch stop;
  EXPECT_TRUE(PressOf("ann", 0).GiveTo(stop));
  EXPECT_TRUE(stop.pressed());
  ResetOf({{"ann", 0}}).GiveTo(stop);
  EXPECT_TRUE(stop.pressed());
  ResetOf(Presses(stop.held())).GiveTo(stop);
  EXPECT_FALSE(stop.pressed());
}

/// What holds by the definition: the presses that no reset covers.
std::set<std::string> HeldByDefinition(const std::vector<Sample>& samples) {
  std::set<std::string> held;
  for (const Sample& press : samples) {
    if (!press.pressed) continue;
    const bool covered =
        std::any_of(samples.begin(), samples.end(), [&](const Sample& reset) {
          return !reset.pressed &&
                 std::any_of(reset.released.begin(), reset.released.end(),
                             [&](const StopPress& released) {
                               return released.source == press.source &&
                                      released.number >= press.number;
                             });
        });
    if (!covered) held.insert(press.source);
  }
  return held;
}

/// Senders press, and reset what they happen to have received: lists of their own.
std::vector<Sample> RandomHistory(std::mt19937& random) {
  std::vector<Sample> samples;
  Presses sent;
  const auto chance = [&](unsigned of) { return random() % of == 0; };
  for (unsigned i = 0, count = 1 + random() % 12; i < count; ++i) {
    const std::string source(1, static_cast<char>('a' + random() % 4));
    const std::uint64_t number = i + 1;
    if (sent.empty() || !chance(2)) {
      samples.push_back(PressOf(source, number));
      sent.push_back({source, number});
      continue;
    }
    Sample reset{source, number, false, {}};
    for (const StopPress& press : sent) {
      if (!chance(3)) reset.released.push_back(press);
    }
    samples.push_back(std::move(reset));
  }
  return samples;
}

// Shuffled, with samples twice, and as different listeners receive them.
TEST(StopLatch, IsTheSameInEveryOrder) {
  std::mt19937 random(18);
  int pressed = 0, free = 0;
  for (int history = 0; history < 3000; ++history) {
    std::vector<Sample> samples = RandomHistory(random);
    const std::set<std::string> expected = HeldByDefinition(samples);
    ++(expected.empty() ? free : pressed);
    for (int order = 0; order < 4; ++order) {
      std::vector<Sample> received = samples;
      for (unsigned i = 0; i < random() % 5; ++i)
        received.push_back(samples[random() % samples.size()]);
      std::shuffle(received.begin(), received.end(), random);
      StopLatch stop;
      bool came = false, held_once = false;
      for (const Sample& sample : received) {
        came = sample.GiveTo(stop) || came;
        held_once = held_once || stop.pressed();
      }
      std::set<std::string> held;
      for (const StopPress& press : stop.held()) held.insert(press.source);
      ASSERT_EQ(held, expected) << "history " << history << ", order " << order;
      ASSERT_EQ(stop.pressed(), !expected.empty());
      ASSERT_TRUE(came || !held_once) << "a press without notice";
    }
  }
  EXPECT_GT(pressed, 300);
  EXPECT_GT(free, 300);
}

// The reset names what its sender received and is lost on its way to some listeners: in
// no order does a listener release a press that is on no list.
TEST(StopLatch, NoOrderReleasesAPressThatNobodyNamed) {
  std::mt19937 random(6);
  for (int history = 0; history < 1000; ++history) {
    std::vector<Sample> samples = RandomHistory(random);
    samples.push_back(PressOf("unheard", 1 + random() % 3));
    StopLatch stop;
    bool received = false;
    std::shuffle(samples.begin(), samples.end(), random);
    for (const Sample& sample : samples) {
      sample.GiveTo(stop);
      received = received || sample.source == "unheard";
      ASSERT_TRUE(!received || stop.pressed());
    }
  }
}

TEST(StopLatch, ForgetsWhatIsReleasedAndNeverWhatIsHeld) {
  StopLatch stop;
  PressOf("held", 1).GiveTo(stop);
  for (std::size_t i = 0; i < 10 * StopLatch::kMaxSources; ++i) {
    const std::string source = "s" + std::to_string(i);
    EXPECT_TRUE(PressOf(source, 1).GiveTo(stop));
    ResetOf({{source, 1}}).GiveTo(stop);
    EXPECT_EQ(stop.held(), (Presses{{"held", 1}}));
  }
  EXPECT_FALSE(PressOf("held", 1).GiveTo(stop));
  EXPECT_TRUE(PressOf("s0", 1).GiveTo(stop)) << "forgotten: it stops again";
}

TEST(StopLatch, APressForWhichThereIsNoRoomHoldsItForGood) {
  StopLatch stop;
  Presses all;
  for (std::size_t i = 0; i < StopLatch::kMaxSources; ++i) {
    all.push_back({"s" + std::to_string(i), 1});
    PressOf(all.back().source, 1).GiveTo(stop);
  }
  const std::uint64_t before = stop.revision();
  EXPECT_TRUE(PressOf("one more", 1).GiveTo(stop));
  EXPECT_GT(stop.revision(), before);
  EXPECT_EQ(stop.held().size(), StopLatch::kMaxSources);
  all.push_back({"one more", 1});
  ResetOf(all).GiveTo(stop);
  EXPECT_TRUE(stop.held().empty());
  EXPECT_TRUE(stop.pressed());
  StopLatch other;
  EXPECT_TRUE(
      PressOf(std::string(StopLatch::kMaxSourceLength + 1, 'x'), 1).GiveTo(other));
  EXPECT_TRUE(other.pressed());
}

// A synchronizer that starts anew learns of the press from its motion bridge; and a reset
// that did not reach the bridge is not over.
TEST(StopLatch, HoldsWhatAnotherListenerReports) {
  StopLatch stop;
  const Presses of_ann{{"ann", 2}}, of_bob{{"bob", 1}};
  const auto ann = WireOf(of_ann);
  EXPECT_TRUE(stop.TakeHeld("bridge", ann));
  EXPECT_FALSE(stop.TakeHeld("bridge", ann));
  EXPECT_EQ(stop.held(), (Presses{{"ann", 2}}));
  ResetOf({{"ann", 2}}).GiveTo(stop);
  EXPECT_EQ(stop.held(), (Presses{{"ann", 2}})) << "the bridge still holds it";
  EXPECT_FALSE(stop.TakeHeld("job service", {}));
  EXPECT_TRUE(stop.pressed());
  EXPECT_FALSE(stop.TakeHeld("bridge", {}));
  EXPECT_FALSE(stop.pressed());
  // A report of before the reset is no new press.
  EXPECT_FALSE(stop.TakeHeld("job service", ann));
  EXPECT_FALSE(stop.TakeHeld("job service", {}));
  EXPECT_FALSE(stop.pressed());
  // A listener that is lost releases nothing.
  stop.TakeHeld("bridge", WireOf(of_bob));
  stop.TakeHeld("bridge", {});
  EXPECT_EQ(stop.held(), (Presses{{"bob", 1}}));
}

}  // namespace
}  // namespace intaglio::host
