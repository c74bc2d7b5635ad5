// `intaglio stop` as a process. The machines are in this one: each takes emergency stops
// and reports them as a synchronizer does.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/identity.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/safety/stop_latch.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;
using Clock = std::chrono::steady_clock;

constexpr int kDomain = 48;

class Machine {
 public:
  enum class Answers { kAll, kNothing };

  Machine(bus::Bus& bus, std::string cell, Answers answers = Answers::kAll)
      : cell_(std::move(cell)),
        answers_(answers),
        stops_(bus, bus::kEmergencyStop, cell_),
        interlocks_(bus, bus::kInterlock, cell_),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  bool pressed() const {
    const std::lock_guard lock(mutex_);
    return latch_.pressed();
  }
  std::vector<host::StopPress> held() const {
    const std::lock_guard lock(mutex_);
    return latch_.held();
  }
  std::optional<Clock::time_point> pressed_at() const {
    const std::lock_guard lock(mutex_);
    return pressed_at_;
  }
  /// As its laser controller reports them from now on.
  void SetInterlocks(bool key_on, bool door_closed) {
    const std::lock_guard lock(mutex_);
    key_on_ = key_on;
    door_closed_ = door_closed;
  }
  /// Its own stop is latched, as after a press of its button; a reset of a press that
  /// held the machine takes it back, unless the button `is_pressed`.
  void LatchOwnStop(bool is_pressed) {
    const std::lock_guard lock(mutex_);
    own_stop_latched_ = true;
    own_button_pressed_ = is_pressed;
    changed_ = true;
  }
  bool own_stop_latched() const {
    const std::lock_guard lock(mutex_);
    return own_stop_latched_;
  }
  /// Another source presses at the moment when a reset is taken.
  void PressAtTheNextReset(const std::string& source) {
    const std::lock_guard lock(mutex_);
    press_at_reset_ = source;
  }

 private:
  void Run(const std::stop_token& stop) {
    auto reported_at = Clock::now() - 1h;
    for (std::uint64_t reported = 0; !stop.stop_requested();) {
      std::this_thread::sleep_for(1ms);
      const std::lock_guard lock(mutex_);
      stops_.Take([this](const intaglio_EmergencyStop& sample) { Receive(sample); });
      const bool changed = std::exchange(changed_, false);
      if (!changed && reported == latch_.revision() && Clock::now() - reported_at < 1s)
        continue;
      reported = latch_.revision();
      reported_at = Clock::now();
      Report();
    }
  }
  void Receive(const intaglio_EmergencyStop& sample) {
    if (!sample.pressed && !press_at_reset_.empty())
      latch_.TakePress(std::exchange(press_at_reset_, {}), 1);
    const bool was_pressed = latch_.pressed();
    latch_.Receive(sample);
    const bool is_reset = was_pressed && !latch_.pressed() && !own_button_pressed_;
    if (is_reset) own_stop_latched_ = false;
    if (latch_.pressed() && !pressed_at_) pressed_at_ = Clock::now();
  }
  void Report() {
    intaglio_Interlock sample{};
    const std::string message;
    sample.cell = bus::Borrow(cell_);
    sample.message = bus::Borrow(message);
    const auto held = host::WireOf(latch_.held());
    sample.laser_link_up = true;
    sample.emergency_stop_released = !own_stop_latched_;
    sample.key_on = key_on_;
    sample.door_closed = door_closed_;
    if (answers_ == Answers::kAll) {
      sample.bus_stop_pressed = latch_.pressed();
      bus::Borrow(sample.bus_stops, held);
    }
    (void)interlocks_.Write(sample);
  }

  const std::string cell_;
  const Answers answers_;
  mutable std::mutex mutex_;  // of what follows
  bus::Reader<intaglio_EmergencyStop> stops_;
  bus::Writer<intaglio_Interlock> interlocks_;
  host::StopLatch latch_;
  std::optional<Clock::time_point> pressed_at_;
  std::string press_at_reset_;
  bool key_on_ = true, door_closed_ = true;
  bool own_stop_latched_ = false, own_button_pressed_ = false, changed_ = false;
  std::jthread thread_;
};

class Stop : public ::testing::Test {
 protected:
  bus::BusOptions Options() const {
    bus::BusOptions options;
    options.control_domain = kDomain;
    options.tag = Tag();
    return options;
  }
  static std::string Tag() { return "stop" + std::to_string(getpid()); }
  std::unique_ptr<Running> Start(std::vector<std::string> words) {
    words.insert(words.begin(), "stop");
    words.insert(words.end(), {"--domain", std::to_string(kDomain), "--tag", Tag()});
    return std::make_unique<Running>(
        Program("intaglio"), words,
        folder_ / ("typed" + std::to_string(++typed_) + ".txt"));
  }
  Ended Type(std::vector<std::string> words) {
    return Start(std::move(words))->WaitForEnd(60s);
  }

  fs::path folder_ = test::FreshFolder();
  int typed_ = 0;
};

// The time until other processes are discovered is 1.5 s: a program that waits for it
// first presses later than that.
TEST_F(Stop, PressesBeforeItSearchesForMachines) {
  std::vector<long> milliseconds;
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>(5)) {
    bus::Bus bus(Options());
    Machine first(bus, "els-03"), second(bus, "els-04");
    const auto began = Clock::now();
    const Ended ended = Type(words);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    EXPECT_THAT(ended.output,
                AllOf(HasSubstr("els-03: stopped"), HasSubstr("els-04: stopped")));
    for (const Machine* machine : {&first, &second}) {
      ASSERT_TRUE(machine->pressed_at());
      milliseconds.push_back(std::chrono::duration_cast<std::chrono::milliseconds>(
                                 *machine->pressed_at() - began)
                                 .count());
    }
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  std::cout << fmt::format("  ms from the start of the process to the press taken: {}\n",
                           fmt::join(milliseconds, " "));
  EXPECT_LT(milliseconds[milliseconds.size() / 2], 1000);
}

TEST_F(Stop, StopsAMachineThatStartsMeanwhile) {
  bus::Bus bus(Options());
  Machine first(bus, "els-03");
  const auto stop = Start({});
  ASSERT_TRUE(Eventually([&] { return first.pressed(); }));
  Machine second(bus, "els-04");
  EXPECT_TRUE(Eventually([&] { return second.pressed(); }));
  EXPECT_EQ(stop->WaitForEnd(60s).exit_code, 0) << stop->Output();
}

TEST_F(Stop, OfANamedMachineLeavesTheOthers) {
  bus::Bus bus(Options());
  Machine first(bus, "els-03"), second(bus, "els-04");
  const Ended ended = Type({"els-04"});
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_TRUE(second.pressed());
  EXPECT_FALSE(first.pressed());
}

TEST_F(Stop, AResetLeavesAPressThatItDidNotKnowOf) {
  bus::Bus bus(Options());
  Machine machine(bus, "els-03");
  ASSERT_EQ(Type({}).exit_code, 0);
  ASSERT_EQ(Type({"els-03"}).exit_code, 0);
  ASSERT_EQ(machine.held().size(), 2u);
  machine.PressAtTheNextReset("bob");
  const Ended reset = Type({"--reset"});
  EXPECT_EQ(reset.exit_code, 4) << reset.output;
  EXPECT_THAT(reset.output,
              AllOf(HasSubstr("els-03 is still stopped"), HasSubstr("bob (number 1)")));
  EXPECT_EQ(machine.held(), (std::vector<host::StopPress>{{"bob", 1}}));
  const Ended again = Type({"els-03", "--reset"});
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_FALSE(machine.pressed());
}

TEST_F(Stop, AResetReportsWhatStillHoldsTheMachine) {
  bus::Bus bus(Options());
  Machine machine(bus, "els-03");
  machine.SetInterlocks(false, false);
  ASSERT_EQ(Type({}).exit_code, 0);
  const Ended reset = Type({"els-03", "--reset"});
  EXPECT_EQ(reset.exit_code, 4) << reset.output;
  EXPECT_FALSE(machine.pressed()) << "the stop itself is reset";
  EXPECT_THAT(reset.output,
              AllOf(HasSubstr("the stop is reset"), HasSubstr("the key is off"),
                    HasSubstr("the door is open")));
  machine.SetInterlocks(true, true);
  ASSERT_EQ(Type({}).exit_code, 0);  // its report has the interlocks as they are now
  EXPECT_EQ(Type({"els-03", "--reset"}).exit_code, 0);
}

// Its button was pressed and released again: no press is on the bus.
TEST_F(Stop, AResetTakesTheStopBackThatTheMachineKeepsLatched) {
  bus::Bus bus(Options());
  Machine machine(bus, "els-03");
  machine.LatchOwnStop(false);
  const Ended reset = Type({"els-03", "--reset"});
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  EXPECT_FALSE(machine.own_stop_latched());
  EXPECT_FALSE(machine.pressed());
}

TEST_F(Stop, AResetNamesTheButtonThatIsStillPressed) {
  bus::Bus bus(Options());
  Machine machine(bus, "els-03");
  machine.LatchOwnStop(true);
  const Ended reset = Type({"els-03", "--reset"});
  EXPECT_EQ(reset.exit_code, 4) << reset.output;
  EXPECT_THAT(reset.output, AllOf(HasSubstr("its own stop button is pressed"),
                                  HasSubstr("release the button and reset it again")));
  EXPECT_TRUE(machine.own_stop_latched());
  EXPECT_FALSE(machine.pressed());
}

// A machine that nothing stops is not stopped by a reset.
TEST_F(Stop, AResetOfAMachineThatIsNotStoppedPressesNothing) {
  bus::Bus bus(Options());
  Machine machine(bus, "els-03");
  EXPECT_EQ(Type({"els-03", "--reset"}).exit_code, 0);
  EXPECT_FALSE(machine.pressed_at().has_value());
}

TEST_F(Stop, AResetOfOneOfSeveralMachinesHasToNameIt) {
  bus::Bus bus(Options());
  Machine first(bus, "els-03"), second(bus, "els-04");
  ASSERT_EQ(Type({}).exit_code, 0);
  const Ended any = Type({"--reset"});
  EXPECT_EQ(any.exit_code, 2);
  EXPECT_THAT(any.output, HasSubstr("els-03, els-04"));
  EXPECT_TRUE(first.pressed() && second.pressed());
  EXPECT_EQ(Type({"els-03", "--reset"}).exit_code, 0);
  EXPECT_FALSE(first.pressed());
  EXPECT_TRUE(second.pressed());
}

TEST_F(Stop, ThatIsInterruptedReleasesNothing) {
  for (const int signal : {SIGINT, SIGKILL}) {
    bus::Bus bus(Options());
    Machine machine(bus, "els-03");
    const auto stop = Start({});
    ASSERT_TRUE(Eventually([&] { return machine.pressed(); }));
    stop->Signal(signal);
    EXPECT_EQ(stop->WaitForEnd(60s).exit_code, 128 + signal);
    EXPECT_FALSE(Eventually([&] { return !machine.pressed(); }, 500ms));
  }
}

TEST_F(Stop, AMachineThatDoesNotConfirmIsNamed) {
  bus::Bus bus(Options());
  Machine good(bus, "els-03"), silent(bus, "els-04", Machine::Answers::kNothing);
  const Ended ended = Type({});
  EXPECT_EQ(ended.exit_code, 4);
  EXPECT_THAT(ended.output,
              AllOf(HasSubstr("els-03: stopped"),
                    HasSubstr("els-04 has not confirmed the stop within 5 s"),
                    HasSubstr("own button")));
}

TEST_F(Stop, ANameThatNoMachineHasIsAnsweredWithThoseThatAreThere) {
  bus::Bus bus(Options());
  Machine left(bus, "left"), right(bus, "right");
  const Ended ended = Type({"lft"});
  EXPECT_EQ(ended.exit_code, 4);
  EXPECT_THAT(ended.output,
              HasSubstr("press the machine's own button; no machine of this name is "
                        "there, but left, right"));
  EXPECT_FALSE(left.pressed());
}

TEST_F(Stop, WithoutAMachineIsAnError) {
  const Ended ended = Type({});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.output,
              HasSubstr("no machine found: press the machine's own button"));
  const Ended reset = Type({"els-03", "--reset"});
  EXPECT_EQ(reset.exit_code, 4);
  EXPECT_THAT(reset.output, HasSubstr("check that its synchronizer runs"));
}

// Every machine in one partition "*" is what an operator's identity may write, and what a
// machine's identity lets an operator write.
TEST_F(Stop, WithIdentitiesIsTheOperators) {
  if (!bus::SecurityConfiguration({folder_, {}, {}}))
    GTEST_SKIP() << "the DDS library is here without its security plugins";
  const fs::path keys = folder_ / "keys";
  Running made(Program("intaglio"),
               {"security", "new", keys.string(), "--domain", std::to_string(kDomain)},
               folder_ / "made.txt");
  ASSERT_EQ(made.WaitForEnd(60s).exit_code, 0) << made.Output();
  bus::BusOptions options = Options();
  options.security = keys / "cell-els-03";
  bus::Bus bus(options);
  Machine machine(bus, "els-03");
  const Ended observer = Type({"--security", keys / "observer"});
  EXPECT_NE(observer.exit_code, 0);
  EXPECT_THAT(observer.output, HasSubstr("permissions do not allow it"));
  EXPECT_FALSE(machine.pressed());
  const auto began = Clock::now();
  const Ended ended = Type({"--security", keys / "operator"});
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("els-03: stopped"));
  ASSERT_TRUE(machine.pressed_at());
  std::cout << fmt::format(
      "  {} ms from the start of the process to the press taken\n",
      std::chrono::duration_cast<std::chrono::milliseconds>(*machine.pressed_at() - began)
          .count());
  const Ended reset = Type({"els-03", "--reset", "--security", keys / "operator"});
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  EXPECT_FALSE(machine.pressed());
}

}  // namespace
}  // namespace intaglio
