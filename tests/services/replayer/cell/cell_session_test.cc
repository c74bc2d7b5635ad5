#include "services/replayer/cell/cell_session.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/services/replayer/golden.h"

namespace intaglio::replayer {
namespace {

// The run that was recorded proved 272 points in one pass (its README).
TEST(CellSession, HoldsWhatASynchronizerSentAndReceived) {
  const auto reader = Golden("pyramid.mcap");
  const auto sessions = ReadCellSessions(reader);
  ASSERT_TRUE(sessions) << sessions.error().message;
  ASSERT_EQ(sessions->size(), 1u);
  const CellSession& session = sessions->front();
  EXPECT_EQ(session.job.job().name(), "pyramid");
  EXPECT_TRUE(session.ends_early.empty());
  ASSERT_EQ(session.messages.runs.size(), 1u);
  const CellRun& run = session.messages.runs[0];
  EXPECT_TRUE(run.undisturbed());
  EXPECT_EQ(run.pulses.size(), 272u);
  EXPECT_EQ(std::count(run.pulse.begin(), run.pulse.end(), 1), 272);
  ASSERT_TRUE(session.messages.end);
  EXPECT_EQ(session.messages.end->state, "TASK_DONE");
  // Every pulse is where the motion of the run has it.
  std::uint64_t subticks = 0;
  std::size_t point = 0;
  for (std::size_t i = 0; i < run.pulse.size(); ++i) {
    subticks += run.duration_subticks[i];
    if (run.pulse[i] == 0) continue;
    EXPECT_EQ(run.pulses[point].tick, run.start_tick + subticks / 65536);
    EXPECT_EQ(run.pulses[point].point, point);
    ++point;
  }
}

TEST(CellSession, APauseIsAnEventInTheRunThatItBroke) {
  const auto reader = Golden("paused.mcap");
  const auto sessions = ReadCellSessions(reader);
  ASSERT_TRUE(sessions) << sessions.error().message;
  ASSERT_EQ(sessions->size(), 1u);
  const CellSession& session = sessions->front();
  ASSERT_EQ(session.messages.runs.size(), 2u);
  EXPECT_TRUE(session.messages.runs[0].aborted);
  EXPECT_TRUE(session.messages.runs[1].undisturbed());
  ASSERT_EQ(session.starts_mm.size(), 2u);
  EXPECT_NE(session.starts_mm[0], session.starts_mm[1]);
  bool withdrawn = false;
  for (const CellEvent& event : session.events) {
    const auto* message = std::get_if<PermissionMessage>(&event.message);
    withdrawn = withdrawn || (message != nullptr && !message->granted && event.run == 1);
  }
  EXPECT_TRUE(withdrawn);
}

// A machine whose line was silent for a moment had not closed its shutters, and never
// reported that it had.
TEST(CellSession, ASilentLineIsNoSafeState) {
  const auto reader = Golden("silent.mcap");
  const auto sessions = ReadCellSessions(reader);
  ASSERT_TRUE(sessions) << sessions.error().message;
  ASSERT_EQ(sessions->size(), 1u);
  for (const CellEvent& event : sessions->front().events) {
    const auto* message = std::get_if<InterlockMessage>(&event.message);
    EXPECT_FALSE(message != nullptr && message->safe_state) << event.time_ns;
  }
}

}  // namespace
}  // namespace intaglio::replayer
