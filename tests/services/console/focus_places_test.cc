#include "services/console/focus_places.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

/// A job whose block has its lower corner at x 100, y 20, z 5 of three linear axes; a
/// depth of 10 mm in its glass is one of 6 mm in air.
client::JobView JobIn(const std::filesystem::path& folder) {
  std::ofstream(folder / "job.json") << R"({
      "job": {"block": {"size_mm": {"x": 50, "y": 50, "z": 30}}},
      "optics": {"stage_per_glass_ratio": 0.6},
      "machine": {"block_origin_mm": {"x": 100, "y": 20, "z": 5}}})";
  client::JobView job;
  job.uid = "1-a";
  job.cell = "one";
  job.state = intaglio_JOB_ENGRAVING;
  job.result_directory = folder.string();
  return job;
}

ConsoleState StateOf(FocusPlaces& places, const client::JobView& job, double z_mm) {
  ConsoleState state;
  for (const char* cell : {"one", "other"}) {
    StagePosition& stage = *state.add_stages();
    stage.set_cell(cell);
    stage.set_x_mm(112);
    stage.set_y_mm(25);
    stage.set_z_mm(z_mm);
  }
  places.Add({{job.uid, job}}, state);
  return state;
}

TEST(FocusPlaces, HasTheFocusInTheGlassOfTheJobAtWork) {
  const client::JobView job = JobIn(test::FreshFolder());
  CloudReader files;
  FocusPlaces places(files);
  ConsoleState state = StateOf(places, job, 29);
  for (int i = 0; i < 1000 && !state.stages(0).has_focus_mm(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    state = StateOf(places, job, 29);
  }
  EXPECT_EQ(state.stages(0).job(), "1-a");
  // In air 6 mm below the top face, which is at z 35.
  EXPECT_NEAR(state.stages(0).focus_mm().x(), 12, 1e-9);
  EXPECT_NEAR(state.stages(0).focus_mm().y(), 5, 1e-9);
  EXPECT_NEAR(state.stages(0).focus_mm().z(), 20, 1e-9);
  EXPECT_EQ(state.stages(1).job(), "");
  EXPECT_FALSE(state.stages(1).has_focus_mm());
}

TEST(FocusPlaces, AreNotThoseOfAJobThatWaits) {
  client::JobView job = JobIn(test::FreshFolder());
  job.state = intaglio_JOB_WAITING_FOR_ARM;
  CloudReader files;
  FocusPlaces places(files);
  EXPECT_EQ(StateOf(places, job, 29).stages(0).job(), "");
}

TEST(FocusPlaces, AreNotKnownWithoutTheJobsFolder) {
  client::JobView job = JobIn(test::FreshFolder());
  job.result_directory += "/elsewhere";
  CloudReader files;
  FocusPlaces places(files);
  for (int i = 0; i < 5; ++i) {
    const ConsoleState state = StateOf(places, job, 29);
    EXPECT_EQ(state.stages(0).job(), "1-a");
    EXPECT_FALSE(state.stages(0).has_focus_mm());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace
}  // namespace intaglio::console
