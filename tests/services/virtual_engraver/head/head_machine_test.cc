#include "services/virtual_engraver/head/head_machine.h"

#include <gtest/gtest.h>

#include "tests/services/virtual_engraver/machine_bench.h"
#include "tests/test_folder.h"

namespace intaglio::virtual_engraver {
namespace {

using namespace std::chrono_literals;

// More answers than the machine keeps before it reports anything else: they leave, and
// the host gets its status again.
TEST(HeadMachine, AnswersMoreQuestionsAtOnceThanItKeeps) {
  std::chrono::nanoseconds now = 1s;
  const link::SteadyClock clock = [&] { return now; };
  auto machine = HeadMachine::Make({}, test::FreshFolder() / "marks", clock).value();
  const auto to_machine = std::make_shared<BenchLine::Wire>();
  const auto to_host = std::make_shared<BenchLine::Wire>();
  machine->Plug(std::make_unique<BenchLine>(to_machine, to_host));
  link::LinkOptions options;
  options.window_frames = 1024;
  link::ReliableLink host(link::Side::kHost,
                          std::make_unique<BenchLine>(to_host, to_machine), clock,
                          options);
  std::size_t answers = 0, statuses = 0;
  const auto turn = [&] {
    ASSERT_TRUE(host.Poll([&](std::uint8_t type, std::span<const std::byte>) {
      answers += type == static_cast<std::uint8_t>(link::HeadFrame::kHeadPast) ? 1 : 0;
      statuses += type == static_cast<std::uint8_t>(link::HeadFrame::kHeadStatus) ? 1 : 0;
    }));
    machine->Turn();
    now += 1ms;
  };
  for (int i = 0; i < 500 && !host.up(); ++i) turn();
  ASSERT_TRUE(host.up());
  constexpr std::size_t kQuestions = 2 * DeviceLine::kMaxWaiting;
  const auto question = Encode(link::HeadPastRequest{1, 0, 1});
  for (std::size_t i = 0; i < kQuestions; ++i) {
    ASSERT_TRUE(host.CanSend());
    ASSERT_TRUE(host.Send(static_cast<std::uint8_t>(link::HeadFrame::kHeadPastRequest),
                          question));
  }
  for (int i = 0; i < 500 && answers < kQuestions; ++i) turn();
  EXPECT_EQ(answers, kQuestions);
  const std::size_t before = statuses;
  for (int i = 0; i < 100; ++i) turn();
  EXPECT_GT(statuses, before);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
