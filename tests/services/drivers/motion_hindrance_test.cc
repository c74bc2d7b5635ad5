// What a driver's state makes of a run that is to begin.

#include <gtest/gtest.h>

#include "services/drivers/interface/hand_motion.h"

namespace intaglio::drivers {
namespace {

constexpr char kHome[] =
    "the controller does not know where its axes are: home it (intaglio teach home)";

DriverState Up(intaglio_MotionFault fault, std::string message) {
  DriverState state;
  state.link_up = true;
  state.fault = fault;
  state.message = std::move(message);
  return state;
}

TEST(MotionHindrance, IsTheFaultWhereThePlaceIsKnown) {
  EXPECT_EQ(FindHindrance(Up(intaglio_MOTION_OK, "")), MotionHindrance());
  EXPECT_EQ(FindHindrance(Up(intaglio_MOTION_STARVED, "too slow, then resume")),
            (MotionHindrance{intaglio_MOTION_STARVED, "too slow, then resume"}));
}

TEST(MotionHindrance, IsThePlaceBehindEveryFaultThatARunClears) {
  DriverState state = Up(intaglio_MOTION_OK, "");
  state.homed = false;
  EXPECT_EQ(FindHindrance(state),
            (MotionHindrance{intaglio_MOTION_PLACE_LOST,
                             std::string(kHome) + ", then resume"}));
  state.fault = intaglio_MOTION_FOLLOWING_ERROR;
  state.message = "free the stage, then resume";
  EXPECT_EQ(FindHindrance(state),
            (MotionHindrance{intaglio_MOTION_PLACE_LOST,
                             "free the stage; " + std::string(kHome) + ", then resume"}));
  state.homed = true;
  state.place_lost = "state the zero";
  EXPECT_EQ(FindHindrance(state),
            (MotionHindrance{intaglio_MOTION_PLACE_LOST,
                             "free the stage; state the zero, then resume"}));
}

TEST(MotionHindrance, NamesTheRemedyOnce) {
  DriverState state = Up(intaglio_MOTION_SAFE_STATE, kHome);
  state.homed = false;
  const std::string once = std::string(kHome) + ", then resume";
  EXPECT_EQ(FindHindrance(state).message, once);
  state.message = once;
  EXPECT_EQ(FindHindrance(state).message, once);
  state.message = "the switch of x was met: free it, and home it (intaglio teach home)";
  EXPECT_EQ(FindHindrance(state).message, state.message + ", then resume");
  state.how_to_home = ", until it says so";
  state.message = "";
  EXPECT_EQ(FindHindrance(state).message,
            "the controller does not know where its axes are: home it, until it says so, "
            "then resume");
}

TEST(MotionHindrance, OfALineThatIsDownAndOfMissingAirIsTheirOwn) {
  for (const auto fault : {intaglio_MOTION_LINK_LOST, intaglio_MOTION_WRONG_CONTROLLER}) {
    DriverState state = Up(fault, "the cable");
    state.link_up = state.homed = false;
    EXPECT_EQ(FindHindrance(state), (MotionHindrance{fault, "the cable"}));
  }
  DriverState state = Up(intaglio_MOTION_NO_AIR, "open the valve");
  state.homed = false;
  EXPECT_EQ(FindHindrance(state).fault, intaglio_MOTION_NO_AIR);
}

}  // namespace
}  // namespace intaglio::drivers
