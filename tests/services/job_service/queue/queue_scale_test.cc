// What a turn of a queue costs does not grow with the jobs that wait in it.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "tests/services/job_service/queue/queue_bench.h"

namespace {

std::size_t allocation_count = 0;

}  // namespace

// Replaced for this program: what is looked at costs a text or a list at least.
void* operator new(std::size_t size) {
  ++allocation_count;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace intaglio::job_service {
namespace {

class QueueScaleTest : public JobQueueTest {
 protected:
  void AddAll(std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t number = from; number <= to; ++number) Add(number);
    queue_.Turn(now_);
  }
  std::size_t AllocationsOfATurn() {
    now_ += 20ms;
    const std::size_t before = allocation_count;
    queue_.Turn(now_);
    (void)queue_.Permissions(now_);
    return allocation_count - before;
  }
};

TEST_F(QueueScaleTest, ATurnAtRestCostsTheSameWhateverWaits) {
  ReadyAll();
  AddAll(1, 10);
  const std::size_t with_few = AllocationsOfATurn();
  AddAll(11, 2000);
  EXPECT_EQ(AllocationsOfATurn(), with_few);
  EXPECT_EQ(queue_.Find("j2000")->queue_place, 1999u);
}

TEST_F(QueueScaleTest, WithoutWorkersItIsTheSame) {
  AddAll(1, 10);
  const std::size_t with_few = AllocationsOfATurn();
  AddAll(11, 2000);
  EXPECT_EQ(AllocationsOfATurn(), with_few);
  EXPECT_EQ(queue_.Find("j2000")->queue_place, 2000u);
}

/// Keeps in which order jobs are published, each once.
class OrderedActions : public RecordingActions {
 public:
  void Changed(const JobRecord& job) override {
    RecordingActions::Changed(job);
    Note(job.uid);
  }
  void Progressed(const JobRecord& job) override { Note(job.uid); }
  std::vector<std::string> published;

 private:
  void Note(const std::string& uid) {
    if (std::ranges::find(published, uid) == published.end()) published.push_back(uid);
  }
};

// A client that has the places of some of them takes none for the first that is not.
TEST(QueuePlaces, AreGivenFromTheFirstToTheLast) {
  std::vector<JobRecord> jobs(3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    jobs[i].number = i + 1;
    jobs[i].uid = fmt::format("j{}", i + 1);
    jobs[i].cell = "c";
    jobs[i].turn = i == 2 ? -1 : std::int64_t{i};
  }
  OrderedActions actions;
  JobQueue queue(actions);
  queue.Restore(std::move(jobs), 0ns, 1s);
  actions.published.clear();
  queue.Turn(1s);
  EXPECT_THAT(actions.published, testing::ElementsAre("j3", "j1", "j2"));
}

}  // namespace
}  // namespace intaglio::job_service
