#include "services/cell/permission_chain.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace intaglio::cell {
namespace {

using State = PermissionChain::State;
using namespace std::chrono_literals;

constexpr unsigned kLinks = 15;
constexpr bool ChainLinks::*kMember[kLinks] = {&ChainLinks::permission_fresh,
                                               &ChainLinks::permission_granted,
                                               &ChainLinks::stop_not_pressed,
                                               &ChainLinks::laser_line_up,
                                               &ChainLinks::key_on,
                                               &ChainLinks::door_closed,
                                               &ChainLinks::stop_released,
                                               &ChainLinks::inputs_hold,
                                               &ChainLinks::no_safe_state,
                                               &ChainLinks::lamp_sync_counted,
                                               &ChainLinks::lamp_warm,
                                               &ChainLinks::motion_fresh,
                                               &ChainLinks::motion_without_fault,
                                               &ChainLinks::shutters_open,
                                               &ChainLinks::door_locked};
constexpr unsigned kAll = (1u << kLinks) - 1;
// The shutters, and the lock that holds the door while one is open.
constexpr unsigned kShutters = 3u << 13;

ChainLinks LinksOfBits(unsigned bits, Grant grant = {1, 0}) {
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

TEST(PermissionLinks, EveryMissingLinkNamesTheRemedy) {
  for (unsigned i = 0; i < kLinks; ++i) {
    const Missing missing = FirstMissing(LinksOfBits(kAll & ~(1u << i)), true);
    EXPECT_NE(missing, Missing::kNothing);
    EXPECT_FALSE(TextOf(missing).empty());
  }
  EXPECT_TRUE(TextOf(Missing::kNothing).empty());
}

// Machines with one input for key, door and stop report all three open.
TEST(PermissionLinks, OfAnOpenChainNoSingleContactIsNamed) {
  const unsigned chain = kAll & ~(1u << 4 | 1u << 5 | 1u << 6);
  EXPECT_EQ(FirstMissing(LinksOfBits(chain), true), Missing::kChain);
  EXPECT_EQ(TextOf(Missing::kChain),
            "key, door or stop button is open: close them, then resume");
  PermissionChain permission;
  permission.Turn(LinksOfBits(kAll, {1, 0}), 1s);
  EXPECT_EQ(permission.Turn(LinksOfBits(chain, {1, 0}), 2s), Missing::kChain);
}

// As key and door: who lets one go gives a new permission, and no renewal suffices.
TEST(PermissionLinks, AnInputThatOpensSpendsTheGrantByItsName) {
  PermissionChain permission;
  const unsigned open = kAll & ~(1u << 7);
  permission.Turn(LinksOfBits(kAll, {1, 0}), 1s);
  EXPECT_EQ(permission.Turn(LinksOfBits(open, {1, 0}), 2s), Missing::kInput);
  EXPECT_EQ(permission.spent_by(), Missing::kInput);
  permission.Turn(LinksOfBits(kAll, {1, 1}), 3s);
  EXPECT_TRUE(permission.latched());
  permission.Turn(LinksOfBits(kAll, {2, 0}), 4s);
  EXPECT_FALSE(permission.latched());
  EXPECT_EQ(FirstMissing(LinksOfBits(open), false), Missing::kInput);
}

// Who has to arm is not known here: the permission of an armed job comes later.
TEST(PermissionLinks, AMissingPermissionAsksNobodyForAnArm) {
  EXPECT_EQ(TextOf(Missing::kPermission), "waits for the permission of the job service");
}

// The machine by a table, in terms of a person at the cell. Soft: latched by a lost line,
// so that the job service may renew the grant. Of the arms, kOld was spent, kRenewed is
// the same with a greater renewal, kNew is a greater number.
enum class From { kClear, kSoft, kLatched, kResetting };
enum class Arm { kNone, kOld, kRenewed, kNew };
enum class Event { kTurn, kLateTurn, kFault, kLostLine };  // late: after kResetTime

struct Situation {
  bool granted;       // the operator's newest permission
  bool armed;         // it is fresh, too
  bool bus_stop;      // pressed on the bus
  bool line;          // the laser line is up
  bool key_or_door;   // key off, door or an input open
  bool machine_stop;  // the machine's own, pressed or latched
  // With the line down the machine's last report counts for nothing.
  bool any_open() const { return bus_stop || (line && (key_or_door || machine_stop)); }
};

// What is left of the arm afterwards: all it was worth, what a renewal of it is worth, or
// nothing.
enum class Left { kWhole, kRenewal, kNothing };

struct Row {
  const char* what;
  From from;
  std::function<bool(const Situation&, Arm, Event)> when;
  State to;
  Left left;
};

// The first row that fits is what happens. Not derived from the code's order of tests.
const std::vector<Row>& Table() {
  using S = const Situation&;
  const auto fault = [](S, Arm, Event e) { return e == Event::kFault; };
  const auto lost = [](S, Arm, Event e) { return e == Event::kLostLine; };
  const auto always = [](S, Arm, Event) { return true; };
  static const std::vector<Row> table = {
      {"fault", From::kClear, fault, State::kLatched, Left::kNothing},
      {"lost line", From::kClear, lost, State::kLatched, Left::kRenewal},
      {"all held", From::kClear, [](S s, Arm, Event) { return !s.any_open(); },
       State::kClear, Left::kWhole},
      {"let go", From::kClear, always, State::kLatched, Left::kNothing},

      // An arm that comes after a fault was given after it.
      {"fault, then a new arm", From::kLatched,
       [](S, Arm a, Event e) { return e >= Event::kFault && a == Arm::kNew; },
       State::kLatched, Left::kWhole},
      {"fault again", From::kLatched, [](S, Arm, Event e) { return e >= Event::kFault; },
       State::kLatched, Left::kNothing},
      {"only a person ends it", From::kLatched,
       [](S, Arm a, Event) { return a != Arm::kNew; }, State::kLatched, Left::kNothing},
      {"arm at a stop of the bus", From::kLatched,
       [](S s, Arm, Event) { return s.bus_stop; }, State::kLatched, Left::kNothing},
      {"arm without a line", From::kLatched, [](S s, Arm, Event) { return !s.line; },
       State::kLatched, Left::kWhole},
      {"arm at an open door", From::kLatched,
       [](S s, Arm, Event) { return s.key_or_door; }, State::kLatched, Left::kNothing},
      {"greater number, withdrawn or stale", From::kLatched,
       [](S s, Arm, Event) { return !s.armed; }, State::kLatched, Left::kWhole},
      {"arm at a latched machine", From::kLatched,
       [](S s, Arm, Event) { return s.machine_stop; }, State::kResetting, Left::kWhole},
      {"arm", From::kLatched, always, State::kClear, Left::kWhole},

      {"fault behind a lost line, then a new arm", From::kSoft,
       [](S, Arm a, Event e) { return e >= Event::kFault && a == Arm::kNew; },
       State::kLatched, Left::kWhole},
      {"fault behind a lost line", From::kSoft, fault, State::kLatched, Left::kNothing},
      {"lost again, renewed after it", From::kSoft,
       [](S, Arm a, Event e) { return e == Event::kLostLine && a == Arm::kRenewed; },
       State::kLatched, Left::kWhole},
      {"lost again", From::kSoft, lost, State::kLatched, Left::kRenewal},
      {"old arm, all held", From::kSoft,
       [](S s, Arm a, Event) { return a <= Arm::kOld && !s.any_open(); }, State::kLatched,
       Left::kRenewal},
      {"let go while latched", From::kSoft,
       [](S s, Arm a, Event) { return a != Arm::kNew && s.any_open(); }, State::kLatched,
       Left::kNothing},
      {"new arm at a stop of the bus", From::kSoft,
       [](S s, Arm, Event) { return s.bus_stop; }, State::kLatched, Left::kNothing},
      {"new arm or renewal without a line", From::kSoft,
       [](S s, Arm, Event) { return !s.line; }, State::kLatched, Left::kWhole},
      {"new arm at an open door", From::kSoft,
       [](S s, Arm, Event) { return s.key_or_door; }, State::kLatched, Left::kNothing},
      {"not granted", From::kSoft, [](S s, Arm, Event) { return !s.armed; },
       State::kLatched, Left::kWhole},
      {"new arm at a latched machine", From::kSoft,
       [](S s, Arm, Event) { return s.machine_stop; }, State::kResetting, Left::kWhole},
      {"new arm or renewal", From::kSoft, always, State::kClear, Left::kWhole},

      {"fault in a reset", From::kResetting, fault, State::kLatched, Left::kNothing},
      {"line lost by a run in a reset", From::kResetting, lost, State::kLatched,
       Left::kRenewal},
      {"withdrawn", From::kResetting, [](S s, Arm, Event) { return !s.granted; },
       State::kLatched, Left::kNothing},
      {"line down", From::kResetting, [](S s, Arm, Event) { return !s.line; },
       State::kLatched, Left::kNothing},
      {"another let go", From::kResetting,
       [](S s, Arm, Event) { return s.bus_stop || s.key_or_door; }, State::kLatched,
       Left::kNothing},
      {"released", From::kResetting,
       [](S s, Arm, Event) { return !s.machine_stop && s.armed; }, State::kClear,
       Left::kWhole},
      {"button held, or the permission late, for too long", From::kResetting,
       [](S, Arm, Event e) { return e == Event::kLateTurn; }, State::kLatched,
       Left::kNothing},
      {"being reset", From::kResetting, always, State::kResetting, Left::kWhole},
  };
  return table;
}

constexpr Grant kOldGrant{7, 3}, kRenewedGrant{7, 4}, kNewGrant{8, 0};
constexpr unsigned kStopped = kAll & ~(1u << 6);

Grant GrantOf(Arm arm) {
  switch (arm) {
    case Arm::kNone:
      return {};
    case Arm::kOld:
      return kOldGrant;
    case Arm::kRenewed:
      return kRenewedGrant;
    case Arm::kNew:
      break;
  }
  return kNewGrant;
}

/// A chain in that state, which in kClear and kResetting has seen the arm already.
PermissionChain ChainIn(From state, Arm arm) {
  PermissionChain chain;
  const auto turn = [&](unsigned bits, Grant grant) {
    chain.Turn(LinksOfBits(bits, grant), 1s);
  };
  const Grant before = arm == Arm::kNone ? Grant{} : kOldGrant;
  turn(kAll, state == From::kClear ? GrantOf(arm) : before);
  if (state == From::kSoft) chain.Latch(true);
  if (state == From::kLatched || state == From::kResetting) turn(kStopped, before);
  if (state == From::kResetting) turn(kStopped, GrantOf(arm));
  return chain;
}

bool CanBeIn(From state, Arm arm) {
  return state != From::kResetting || arm == Arm::kNew;
}

/// Under the best of circumstances: does this grant let it fire, now or after a turn?
bool Revives(PermissionChain chain, Grant grant) {
  const ChainLinks best = LinksOfBits(kAll, grant);
  chain.Turn(best, 10s);
  return grant.number > 0 && chain.WhatIsMissing(best, true) == Missing::kNothing;
}

void Check(From from, Arm arm, Event event, unsigned bits,
           std::map<std::string, int>& used) {
  PermissionChain chain = ChainIn(from, arm);
  const ChainLinks links = LinksOfBits(bits, GrantOf(arm));
  const Situation situation{links.permission_granted,
                            links.permission_fresh && links.permission_granted,
                            !links.stop_not_pressed,
                            links.laser_line_up,
                            !links.key_on || !links.door_closed || !links.inputs_hold,
                            !links.stop_released};
  if (event == Event::kTurn) chain.Turn(links, 1s + 10ms);
  if (event == Event::kLateTurn) {
    chain.Turn(links, 1s + PermissionChain::kResetTime + 1ms);
  }
  if (event >= Event::kFault) chain.Latch(event == Event::kLostLine);
  const auto row = std::find_if(Table().begin(), Table().end(), [&](const Row& r) {
    return r.from == from && r.when(situation, arm, event);
  });
  ASSERT_NE(row, Table().end());
  ++used[row->what];
  const std::string where =
      fmt::format("{} arm {} event {} links {:012b}", row->what, static_cast<int>(arm),
                  static_cast<int>(event), bits);
  ASSERT_EQ(chain.state(), row->to) << where;
  const bool fires = chain.WhatIsMissing(links, true) == Missing::kNothing;
  ASSERT_EQ(fires, row->to == State::kClear && bits == kAll && arm != Arm::kNone)
      << where;
  if (arm == Arm::kNone) return;
  ASSERT_EQ(Revives(chain, GrantOf(arm)), row->left == Left::kWhole) << where;
  const Grant renewed{GrantOf(arm).number, GrantOf(arm).renewal + 1};
  ASSERT_EQ(Revives(chain, renewed), row->left != Left::kNothing) << where;
  ASSERT_TRUE(Revives(chain, {GrantOf(arm).number + 1, 0})) << where;
}

TEST(PermissionChain, EveryStateAndEventGoesWhereTheTableStates) {
  std::map<std::string, int> used;
  for (const From from : {From::kClear, From::kSoft, From::kLatched, From::kResetting}) {
    for (const Arm arm : {Arm::kNone, Arm::kOld, Arm::kRenewed, Arm::kNew}) {
      if (!CanBeIn(from, arm)) continue;
      for (const Event event :
           {Event::kTurn, Event::kLateTurn, Event::kFault, Event::kLostLine}) {
        for (unsigned bits = 0; bits <= kAll; ++bits) {
          Check(from, arm, event, bits, used);
          if (HasFatalFailure()) return;
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
TEST(PermissionChain, ANewArmIsDistinguishedFromAnOldOneByItsNumberAlone) {
  PermissionChain chain;
  chain.Turn(LinksOfBits(kAll, {4, 0}), 1s);
  chain.Latch(false);
  EXPECT_TRUE(chain.has_spent());
  chain.Turn(LinksOfBits(kAll & ~2u, {4, 0}), 2s);  // withdrawn
  chain.Turn(LinksOfBits(kAll, {4, 0}), 3s);        // the same again
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll, {4, 0}), true), Missing::kPermission);
  chain.Turn(LinksOfBits(kAll, {5, 0}), 4s);
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll, {5, 0}), true), Missing::kNothing);
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll, {4, 0}), true), Missing::kPermission);
}

// A job service that was frozen wakes and repeats the grant that it published before
// another one, in its place, published a pause.
TEST(PermissionChain, AnOlderGrantIsWorthNothingAfterAWithdrawal) {
  const ChainLinks older = LinksOfBits(kAll, {4, 0});
  PermissionChain chain;
  chain.Turn(older, 1s);
  EXPECT_EQ(chain.WhatIsMissing(older, true), Missing::kNothing);
  chain.Turn(LinksOfBits(kAll & ~2u, {5, 0}), 2s);
  chain.Turn(older, 3s);
  EXPECT_EQ(chain.WhatIsMissing(older, true), Missing::kPermission);
  EXPECT_FALSE(chain.may_reset(older));
  // Nor after a fault, with a newer one withdrawn meanwhile.
  chain.Latch(true);
  chain.Turn(LinksOfBits(kAll & ~2u, {6, 0}), 4s);
  chain.Turn(LinksOfBits(kAll, {5, 0}), 5s);
  EXPECT_TRUE(chain.latched());
  chain.Turn(LinksOfBits(kAll, {6, 0}), 6s);
  EXPECT_FALSE(chain.latched());
}

TEST(PermissionChain, ReportsWhichInterlockSpentAGrantAndOnlyOnce) {
  const std::pair<unsigned, Missing> interlocks[] = {{2, Missing::kEmergencyStop},
                                                     {4, Missing::kKey},
                                                     {5, Missing::kDoor},
                                                     {6, Missing::kEmergencyStop},
                                                     {7, Missing::kInput}};
  for (const auto& [link, missing] : interlocks) {
    PermissionChain chain;
    const unsigned open = kAll & ~(1u << link);
    EXPECT_EQ(chain.Turn(LinksOfBits(open, {0, 0}), 1s), Missing::kNothing)
        << "no arm yet";
    EXPECT_FALSE(chain.has_spent());
    chain.Turn(LinksOfBits(kAll, {1, 0}), 2s);
    EXPECT_EQ(chain.Turn(LinksOfBits(open, {1, 0}), 3s), missing);
    EXPECT_EQ(chain.Turn(LinksOfBits(open, {1, 0}), 4s), Missing::kNothing);
  }
}

ChainLinks WholeChain(Grant grant, MachineCounters counters) {
  ChainLinks links = LinksOfBits(kAll, grant);
  links.counters = counters;
  return links;
}

bool Fires(const PermissionChain& chain, const ChainLinks& links) {
  return chain.WhatIsMissing(links, true) == Missing::kNothing;
}

// An arm that is repeated, or renewed after a lost line, was given before it.
TEST(PermissionChain, WhatHappenedUnseenCostsTheGrantAndEveryRenewalOfIt) {
  const std::pair<MachineCounters, Missing> events[] = {{{5, 1}, Missing::kOpenedUnseen},
                                                        {{6, 0}, Missing::kPowerCycle}};
  for (const auto& [after, reason] : events) {
    for (const bool line_lost : {false, true}) {
      PermissionChain chain;
      chain.Watch(WholeChain({}, {5, 0}), 1s);
      chain.BeginJob();
      chain.Turn(WholeChain({3, 0}, {5, 0}), 2s);
      ASSERT_TRUE(Fires(chain, WholeChain({3, 0}, {5, 0})));
      if (line_lost) chain.Latch(true);
      EXPECT_EQ(chain.Turn(WholeChain({3, 0}, after), 3s), reason);
      EXPECT_EQ(chain.spent_by(), reason);
      for (const std::uint64_t renewal : {0u, 1u, 9u}) {
        chain.Turn(WholeChain({3, renewal}, after), 4s);
        EXPECT_FALSE(Fires(chain, WholeChain({3, renewal}, after)));
      }
      chain.Turn(WholeChain({4, 0}, after), 5s);
      EXPECT_TRUE(Fires(chain, WholeChain({4, 0}, after)));
      EXPECT_EQ(chain.spent_by(), Missing::kNothing);
    }
  }
}

// The stage's line is down and its bridge says so, 25 s, back, 25 s: nobody saw the stage
// for longer than an arm survives, however fresh the bridge's word is.
TEST(PermissionChain, AStagesLineThatIsDownIsAnAbsenceThoughItsBridgeAnswers) {
  PermissionChain chain;
  chain.Watch(WholeChain({}, {5, 0}), 1s);
  chain.BeginJob();
  const ChainLinks whole = WholeChain({3, 0}, {5, 0});
  ChainLinks down = whole;
  down.motion_without_fault = false;
  down.motion_line_down = true;
  chain.Turn(whole, 2s);
  EXPECT_EQ(chain.Turn(down, 40s), Missing::kNothing);
  EXPECT_EQ(chain.Turn(down, 65s), Missing::kNothing);
  chain.Turn(whole, 66s);
  ASSERT_TRUE(Fires(chain, whole));
  chain.Turn(down, 67s);
  EXPECT_EQ(chain.Turn(down, 72s), Missing::kMotionAway);
  EXPECT_FALSE(Fires(chain, WholeChain({3, 1}, {5, 0}))) << "no renewal helps";
  chain.Turn(whole, 93s);
  chain.Turn(WholeChain({4, 0}, {5, 0}), 94s);
  EXPECT_TRUE(Fires(chain, WholeChain({4, 0}, {5, 0}))) << "a person does";
}

// Armed while the points are made, long before there is anything to fire: its number is
// published, and the permission is not given yet.
TEST(PermissionChain, AnArmIsSpentByADoorThatOpensBeforeThePathIsThere) {
  PermissionChain chain;
  chain.Watch(WholeChain({}, {5, 0}), 1s);
  chain.BeginJob();
  ChainLinks before = WholeChain({2, 0}, {5, 0});
  before.permission_granted = false;
  chain.Turn(before, 2s);
  EXPECT_FALSE(chain.has_spent());
  ChainLinks open = before;
  open.door_closed = false;
  EXPECT_EQ(chain.Turn(open, 3s), Missing::kDoor);
  chain.Turn(before, 4s);
  EXPECT_TRUE(chain.has_lost({2, 0}));
  EXPECT_EQ(chain.spent_by(), Missing::kDoor);
  chain.Turn(WholeChain({2, 0}, {5, 0}), 5s);
  EXPECT_FALSE(Fires(chain, WholeChain({2, 0}, {5, 0})));
  chain.Turn(WholeChain({3, 0}, {5, 0}), 6s);
  EXPECT_TRUE(Fires(chain, WholeChain({3, 0}, {5, 0})));
}

TEST(PermissionChain, AnotherJobBeginsWithGrantsOfItsOwn) {
  PermissionChain chain;
  chain.Watch(WholeChain({}, {5, 0}), 1s);
  chain.BeginJob();
  chain.Turn(WholeChain({9, 0}, {5, 0}), 2s);
  chain.Latch(false);
  chain.BeginJob();
  EXPECT_FALSE(chain.has_spent());
  chain.Turn(WholeChain({1, 0}, {5, 0}), 3s);
  EXPECT_TRUE(Fires(chain, WholeChain({1, 0}, {5, 0})));
}

// The first number that comes may be of an arm from before.
TEST(PermissionChain, AnEventBeforeTheFirstGrantIsKnownCountsAgainstIt) {
  PermissionChain chain;
  chain.BeginJob();
  chain.TakeUp({5, 0});
  chain.Turn(WholeChain({}, {5, 1}), 1s);
  EXPECT_FALSE(chain.has_spent());
  EXPECT_EQ(chain.Turn(WholeChain({4, 2}, {5, 1}), 2s), Missing::kOpenedUnseen);
  EXPECT_FALSE(Fires(chain, WholeChain({4, 2}, {5, 1})));
  chain.Turn(WholeChain({5, 0}, {5, 1}), 3s);
  EXPECT_TRUE(Fires(chain, WholeChain({5, 0}, {5, 1})));
}

TEST(PermissionChain, ATakenUpJobWhoseMachineNobodyKnowsWaitsForAnArm) {
  PermissionChain chain;
  chain.Watch(WholeChain({}, {5, 0}), 1s);
  chain.BeginJob();
  chain.TakeUp({});
  EXPECT_EQ(chain.Turn(WholeChain({4, 2}, {5, 0}), 2s), Missing::kNotWatched);
  EXPECT_FALSE(Fires(chain, WholeChain({4, 2}, {5, 0})));
}

// A Reset is sent on a new arm alone, and the button released after it is no start.
TEST(PermissionChain, AnArmAtAPressedButtonIsSpent) {
  PermissionChain chain;
  const unsigned stopped = kAll & ~(1u << 6);
  chain.Turn(LinksOfBits(kAll, {1, 0}), 1s);
  chain.Turn(LinksOfBits(stopped, {1, 0}), 2s);
  EXPECT_FALSE(chain.may_reset(LinksOfBits(stopped, {1, 0})));
  chain.Turn(LinksOfBits(stopped, {2, 0}), 3s);
  EXPECT_TRUE(chain.may_reset(LinksOfBits(stopped, {2, 0})));
  EXPECT_EQ(chain.Turn(LinksOfBits(stopped, {2, 0}), 4s), Missing::kEmergencyStop);
  EXPECT_FALSE(chain.may_reset(LinksOfBits(stopped, {2, 0})));
  chain.Turn(LinksOfBits(kAll, {2, 0}), 5s);
  EXPECT_EQ(chain.WhatIsMissing(LinksOfBits(kAll, {2, 0}), true), Missing::kPermission);
}

}  // namespace
}  // namespace intaglio::cell
