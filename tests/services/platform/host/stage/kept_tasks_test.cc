#include "services/platform/host/stage/kept_tasks.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::host {
namespace {

class KeptTasksTest : public testing::Test {
 protected:
  void Report(const std::string& job_uid, std::uint32_t part) {
    const std::string text;
    intaglio_TaskStatus sample{};
    sample.job_uid = bus::Borrow(job_uid);
    sample.stage = intaglio_STAGE_ENGRAVE;
    sample.worker = bus::Borrow(worker_);
    sample.part = part;
    sample.message = bus::Borrow(text);
    kept_.Keep(writer_, job_uid, part);
    ASSERT_TRUE(writer_.Write(sample));
  }
  /// What a reader that comes late is given, when it is so much.
  std::set<std::string> Retained(std::size_t count) {
    bus::Bus late(test::PrivateBusOptions());
    bus::Reader<intaglio_TaskStatus> reader(late, bus::kTaskStatus);
    std::set<std::string> tasks;
    EXPECT_TRUE(test::Eventually([&] {
      reader.Take([&tasks](const intaglio_TaskStatus& sample) {
        tasks.insert(std::string(bus::View(sample.job_uid)) + "/" +
                     std::to_string(sample.part));
      });
      return tasks.size() >= count;
    })) << tasks.size();
    return tasks;
  }

  const std::string worker_ = "synchronizer-1";
  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_TaskStatus> writer_{bus_, bus::kTaskStatus};
  KeptTasks kept_{worker_, intaglio_STAGE_ENGRAVE};
};

TEST_F(KeptTasksTest, OfYearsOfTasksTheNewestStayOnTheBus) {
  for (int job = 0; job < 1000; ++job) {
    for (int progress = 0; progress < 3; ++progress) Report(std::to_string(job), 0);
  }
  const auto tasks = Retained(KeptTasks::kKept);
  EXPECT_EQ(tasks.size(), KeptTasks::kKept);
  EXPECT_TRUE(tasks.contains("999/0"));
  EXPECT_TRUE(tasks.contains("936/0"));
  EXPECT_FALSE(tasks.contains("935/0"));
}

TEST_F(KeptTasksTest, PartsOfAJobAreTasksOfTheirOwn) {
  for (std::uint32_t part = 0; part < kMaxParts; ++part) Report("1", part);
  EXPECT_EQ(Retained(kMaxParts).size(), kMaxParts);
}

}  // namespace
}  // namespace intaglio::host
