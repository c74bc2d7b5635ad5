#include "services/console/plans_ahead.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <future>

#include "engrave/formats/point_file.h"
#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

/// A job that has its machine, with a plan of two points.
client::JobView PlannedJob(const std::filesystem::path& folder) {
  formats::PointTable plan;
  plan.points_mm = {{1, 2, 3}, {4, 5, 6}};
  EXPECT_TRUE(formats::WritePly(folder / "path.ply", plan));
  std::ofstream(folder / "job.json")
      << R"({"job": {"block": {"size_mm": {"x": 50, "y": 50, "z": 30}}}})";
  client::JobView job;
  job.uid = "1-a";
  job.state = intaglio_JOB_WAITING_FOR_ARM;
  job.result_directory = folder.string();
  return job;
}

/// What a page gets that asks behind all that was asked for before.
Result<CloudReader::Bytes> PlanAskedBehind(CloudReader& files,
                                           const client::JobView& job) {
  std::promise<Result<CloudReader::Bytes>> answer;
  EXPECT_TRUE(files.AskForPlan(job.result_directory,
                               [&](const auto& bytes) { answer.set_value(bytes); }));
  return answer.get_future().get();
}

// The plan was read while job.json was there; read later, it would be an error.
TEST(PlansAhead, AreReadWhenTheJobHasItsMachine) {
  const client::JobView job = PlannedJob(test::FreshFolder());
  CloudReader files;
  PlansAhead ahead(files);
  ahead.Follow({{job.uid, job}});
  std::promise<void> done;
  ASSERT_TRUE(files.Ask([&] { done.set_value(); }));
  done.get_future().wait();
  std::filesystem::remove(job.result_directory + "/job.json");
  EXPECT_TRUE(PlanAskedBehind(files, job));
}

TEST(PlansAhead, AreNotReadOfAJobThatIsQueued) {
  client::JobView job = PlannedJob(test::FreshFolder());
  job.state = intaglio_JOB_QUEUED;
  CloudReader files;
  PlansAhead ahead(files);
  ahead.Follow({{job.uid, job}});
  std::promise<void> done;
  ASSERT_TRUE(files.Ask([&] { done.set_value(); }));
  done.get_future().wait();
  std::filesystem::remove(job.result_directory + "/job.json");
  EXPECT_FALSE(PlanAskedBehind(files, job));
}

}  // namespace
}  // namespace intaglio::console
