#include "services/synchronizer/permission_chain.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace intaglio::synchronizer {
namespace {

using State = PermissionChain::State;
using namespace std::chrono_literals;

constexpr unsigned kLinks = 12;
constexpr bool ChainLinks::*kMember[kLinks] = {&ChainLinks::permission_fresh,
                                               &ChainLinks::permission_granted,
                                               &ChainLinks::stop_not_pressed,
                                               &ChainLinks::laser_line_up,
                                               &ChainLinks::key_on,
                                               &ChainLinks::door_closed,
                                               &ChainLinks::stop_released,
                                               &ChainLinks::no_safe_state,
                                               &ChainLinks::lamp_warm,
                                               &ChainLinks::motion_fresh,
                                               &ChainLinks::motion_without_fault,
                                               &ChainLinks::shutters_open};
constexpr unsigned kAll = (1u << kLinks) - 1;
constexpr unsigned kShutters = 1u << 11;

ChainLinks LinksOfBits(unsigned bits, std::uint64_t grant = 1) {
  ChainLinks links;
  for (unsigned i = 0; i < kLinks; ++i) links.*kMember[i] = (bits >> i & 1u) != 0;
  links.grant = grant;
  return links;
}

TEST(PermissionLinks, OnlyTheWholeChainPermits) {
  for (unsigned bits = 0; bits < 1u << kLinks; ++bits) {
    EXPECT_EQ(FirstMissing(LinksOfBits(bits), true) == Missing::kNothing, bits == kAll)
        << bits;
    EXPECT_EQ(FirstMissing(LinksOfBits(bits), false) == Missing::kNothing,
              (bits | kShutters) == kAll)
        << bits;
  }
}

TEST(PermissionLinks, EveryMissingLinkSaysWhatToDo) {
  for (unsigned i = 0; i < kLinks; ++i) {
    const Missing missing = FirstMissing(LinksOfBits(kAll & ~(1u << i)), true);
    EXPECT_NE(missing, Missing::kNothing);
    EXPECT_FALSE(TextOf(missing).empty());
  }
  EXPECT_TRUE(TextOf(Missing::kNothing).empty());
}

// The machine by a table, in the words of a person at the cell. What an arm is worth:
// kOld was spent, kNew is greater than all that were.
enum class Arm { kNone, kOld, kNew };
enum class Event { kTurn, kLateTurn, kFault };  // late: after kResetTime

struct Situation {
  bool armed;         // the operator's word is fresh and granted
  bool bus_stop;      // pressed on the bus
  bool line;          // the laser line is up
  bool key_or_door;   // key off or door open
  bool machine_stop;  // the machine's own, pressed or latched
  // With the line down what was said last of the machine counts for nothing.
  bool any_open() const { return bus_stop || (line && (key_or_door || machine_stop)); }
};

struct Row {
  const char* what;
  State from;
  std::function<bool(const Situation&, Arm, Event)> when;
  State to;
  bool spends;
};

// The first row that fits is what happens. Not derived from the code's order of tests.
const std::vector<Row>& Table() {
  using S = const Situation&;
  static const std::vector<Row> table = {
      {"fault", State::kClear, [](S, Arm, Event e) { return e == Event::kFault; },
       State::kLatched, true},
      // What comes after it was given after it.
      {"fault", State::kLatched, [](S, Arm, Event e) { return e == Event::kFault; },
       State::kLatched, false},
      {"fault", State::kResetting, [](S, Arm, Event e) { return e == Event::kFault; },
       State::kLatched, true},

      {"all held", State::kClear, [](S s, Arm, Event) { return !s.any_open(); },
       State::kClear, false},
      {"let go", State::kClear, [](S s, Arm, Event) { return s.any_open(); },
       State::kLatched, true},

      {"old or no arm", State::kLatched, [](S, Arm a, Event) { return a != Arm::kNew; },
       State::kLatched, false},
      {"arm at a stop of the bus", State::kLatched,
       [](S s, Arm, Event) { return s.bus_stop; }, State::kLatched, true},
      {"arm without a line", State::kLatched, [](S s, Arm, Event) { return !s.line; },
       State::kLatched, false},
      {"arm at an open door", State::kLatched,
       [](S s, Arm, Event) { return s.key_or_door; }, State::kLatched, true},
      {"greater number, withdrawn or stale", State::kLatched,
       [](S s, Arm, Event) { return !s.armed; }, State::kLatched, false},
      {"arm at a latched machine", State::kLatched,
       [](S s, Arm, Event) { return s.machine_stop; }, State::kResetting, false},
      {"arm", State::kLatched, [](S, Arm, Event) { return true; }, State::kClear, false},

      {"withdrawn", State::kResetting, [](S s, Arm, Event) { return !s.armed; },
       State::kLatched, true},
      {"line lost", State::kResetting, [](S s, Arm, Event) { return !s.line; },
       State::kLatched, true},
      {"another let go", State::kResetting,
       [](S s, Arm, Event) { return s.bus_stop || s.key_or_door; }, State::kLatched,
       true},
      {"released", State::kResetting, [](S s, Arm, Event) { return !s.machine_stop; },
       State::kClear, false},
      {"button held", State::kResetting,
       [](S, Arm, Event e) { return e == Event::kLateTurn; }, State::kLatched, true},
      {"being reset", State::kResetting, [](S, Arm, Event) { return true; },
       State::kResetting, false},
  };
  return table;
}

constexpr unsigned kWhole = kAll;
constexpr std::uint64_t kOldGrant = 7, kNewGrant = 8;

/// A chain in `state`. kClear: the grant kOldGrant is spent, and kNewGrant, when `arm` is
/// kNew, not seen yet; else no grant was ever seen.
PermissionChain ChainIn(State state, Arm arm) {
  PermissionChain chain;
  const auto turn = [&](unsigned bits, std::uint64_t grant) {
    chain.Turn(LinksOfBits(bits, grant), 1s);
  };
  const unsigned stopped = kWhole & ~(1u << 6);
  if (arm == Arm::kNone) {
    // Without any grant there is no way out of kLatched.
    if (state == State::kLatched) turn(stopped, 0);
    return chain;
  }
  if (state == State::kClear && arm == Arm::kOld) {
    turn(kWhole, kOldGrant);
    return chain;
  }
  turn(kWhole, kOldGrant);
  turn(stopped, kOldGrant);
  if (state == State::kLatched) return chain;
  if (state == State::kResetting) turn(stopped, kNewGrant);
  if (state == State::kClear) turn(kWhole, kNewGrant);
  return chain;
}

std::uint64_t GrantOf(Arm arm) {
  return arm == Arm::kNone ? 0 : arm == Arm::kOld ? kOldGrant : kNewGrant;
}

TEST(PermissionChain, EveryStateAndEventGoesWhereTheTableSays) {
  std::map<std::string, int> used;
  for (const State state : {State::kClear, State::kLatched, State::kResetting}) {
    for (const Arm arm : {Arm::kNone, Arm::kOld, Arm::kNew}) {
      if (state == State::kResetting && arm != Arm::kNew) continue;  // there is no way
      for (const Event event : {Event::kTurn, Event::kLateTurn, Event::kFault}) {
        for (unsigned bits = 0; bits <= kAll; ++bits) {
          PermissionChain chain = ChainIn(state, arm);
          ASSERT_EQ(chain.state(), state);
          const ChainLinks links = LinksOfBits(bits, GrantOf(arm));
          const Situation situation{links.permission_fresh && links.permission_granted,
                                    !links.stop_not_pressed, links.laser_line_up,
                                    !links.key_on || !links.door_closed,
                                    !links.stop_released};
          if (event == Event::kFault) {
            chain.Latch();
          } else {
            chain.Turn(links, event == Event::kTurn
                                  ? 1s + 10ms
                                  : 1s + PermissionChain::kResetTime + 1ms);
          }
          const auto& table = Table();
          const auto row = std::find_if(table.begin(), table.end(), [&](const Row& r) {
            return r.from == state && r.when(situation, arm, event);
          });
          ASSERT_NE(row, table.end());
          ++used[fmt::format("{}/{}", static_cast<int>(row->from), row->what)];
          const std::string where =
              fmt::format("{} arm {} event {} links {:012b}", row->what,
                          static_cast<int>(arm), static_cast<int>(event), bits);
          ASSERT_EQ(chain.state(), row->to) << where;
          // Whatever was spent stays so under the best of circumstances.
          const bool worth = chain.WhatIsMissing(LinksOfBits(kWhole, GrantOf(arm)),
                                                 true) == Missing::kNothing;
          const bool unspent = arm != Arm::kNone && !row->spends &&
                               !(arm == Arm::kOld && state != State::kClear);
          ASSERT_EQ(worth, unspent && row->to == State::kClear) << where;
          PermissionChain later = chain;
          later.Turn(LinksOfBits(kWhole, GrantOf(arm)), 10s);
          later.Turn(LinksOfBits(kWhole, GrantOf(arm)), 10s);
          const bool revived = later.WhatIsMissing(LinksOfBits(kWhole, GrantOf(arm)),
                                                   true) == Missing::kNothing;
          ASSERT_EQ(revived, unspent) << where;
          // And a pulse is allowed at this very turn only with everything.
          const bool fires = chain.WhatIsMissing(links, true) == Missing::kNothing;
          ASSERT_EQ(fires, worth && bits == kAll) << where;
        }
      }
    }
  }
  EXPECT_EQ(used.size(), Table().size()) << "a row that nothing fits is wrong";
}

TEST(PermissionChain, APermissionThatIsOnlyLateIsNotSpent) {
  PermissionChain chain;
  chain.Turn(LinksOfBits(kAll), 1s);
  chain.Turn(LinksOfBits(kAll & ~1u), 2s);  // not fresh
  EXPECT_NE(chain.WhatIsMissing(LinksOfBits(kAll & ~1u), true), Missing::kNothing);
  chain.Turn(LinksOfBits(kAll), 3s);
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll), true), Missing::kNothing);
}

// The withdrawal between two grants may never have been seen, and a late sample repeats
// an old one.
TEST(PermissionChain, ANewArmIsToldFromAnOldOneByItsNumberAlone) {
  PermissionChain chain;
  chain.Turn(LinksOfBits(kAll, 4), 1s);
  chain.Latch();
  EXPECT_TRUE(chain.has_spent());
  chain.Turn(LinksOfBits(kAll & ~2u, 4), 2s);  // withdrawn
  chain.Turn(LinksOfBits(kAll, 4), 3s);        // the same again
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll, 4), true), Missing::kPermission);
  chain.Turn(LinksOfBits(kAll, 5), 4s);
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll, 5), true), Missing::kNothing);
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll, 4), true), Missing::kPermission);
}

TEST(PermissionChain, TellsWhichInterlockSpentAGrantAndOnlyOnce) {
  const std::pair<unsigned, Missing> interlocks[] = {{2, Missing::kEmergencyStop},
                                                     {4, Missing::kKey},
                                                     {5, Missing::kDoor},
                                                     {6, Missing::kEmergencyStop}};
  for (const auto& [link, missing] : interlocks) {
    PermissionChain chain;
    const unsigned open = kAll & ~(1u << link);
    EXPECT_EQ(chain.Turn(LinksOfBits(open, 0), 1s), Missing::kNothing) << "no arm yet";
    EXPECT_FALSE(chain.has_spent());
    chain.Turn(LinksOfBits(kAll, 1), 2s);
    EXPECT_EQ(chain.Turn(LinksOfBits(open, 1), 3s), missing);
    EXPECT_EQ(chain.Turn(LinksOfBits(open, 1), 4s), Missing::kNothing);
  }
}

// A Reset is sent on a new arm alone, and the button released after it is no start.
TEST(PermissionChain, AnArmAtAPressedButtonIsSpent) {
  PermissionChain chain;
  const unsigned stopped = kAll & ~(1u << 6);
  chain.Turn(LinksOfBits(kAll, 1), 1s);
  chain.Turn(LinksOfBits(stopped, 1), 2s);
  EXPECT_FALSE(chain.may_reset(LinksOfBits(stopped, 1)));
  chain.Turn(LinksOfBits(stopped, 2), 3s);
  EXPECT_TRUE(chain.may_reset(LinksOfBits(stopped, 2)));
  EXPECT_EQ(chain.Turn(LinksOfBits(stopped, 2), 4s), Missing::kEmergencyStop);
  EXPECT_FALSE(chain.may_reset(LinksOfBits(stopped, 2)));
  chain.Turn(LinksOfBits(kAll, 2), 5s);
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll, 2), true), Missing::kPermission);
}

}  // namespace
}  // namespace intaglio::synchronizer
