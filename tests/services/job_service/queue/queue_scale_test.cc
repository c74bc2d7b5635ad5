// What a turn of a queue costs does not grow with the jobs that wait in it.

#include <cstdlib>
#include <new>

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

}  // namespace
}  // namespace intaglio::job_service
