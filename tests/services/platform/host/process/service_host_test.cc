// What every service does, seen on the sorter.

#include "services/platform/host/process/service_host.h"

#include <gtest/gtest.h>

#include "services/platform/host/process/poll_loop.h"
#include "tests/services/platform/host/stage/stage_shop.h"

namespace intaglio::host {
namespace {

using namespace std::chrono_literals;
using test::ChildProgram;
using test::Eventually;
using test::StageShop;

const std::string kSorter = INTAGLIO_BIN_DIR "/intaglio-sorter";

TEST(ServiceHost, ReportsItsVersionAndRefusesWrongOptions) {
  EXPECT_EQ(ChildProgram(kSorter, {"--version"}).ExitCode(), 0);
  EXPECT_EQ(ChildProgram(kSorter, {"--help"}).ExitCode(), 0);
  EXPECT_EQ(ChildProgram(kSorter, {"--no-such-option"}).ExitCode(), 2);
  EXPECT_EQ(ChildProgram(kSorter, {"--domain", "1000"}).ExitCode(), 2);
}

TEST(ServiceHost, EndsWithAnErrorWhenItCannotJoinTheBus) {
  EXPECT_EQ(ChildProgram(kSorter, {"--interface", "no-such-interface"}).ExitCode(), 1);
  EXPECT_EQ(ChildProgram(kSorter, {"--log-file", "/dev/null/log"}).ExitCode(), 1);
}

TEST(ServiceHost, IsReadyAndEndsInOrder) {
  StageShop shop("intaglio-sorter", intaglio_STAGE_SORT, bus::kSortTask);
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
  EXPECT_EQ(shop.instance().substr(0, 7), "sorter-");
  shop.worker().Signal(SIGTERM);
  EXPECT_EQ(shop.worker().ExitCode(), 0);
  EXPECT_TRUE(shop.AwaitGone());
}

TEST(ServiceHost, IsMissedSoonWhenItIsKilled) {
  StageShop shop("intaglio-sorter", intaglio_STAGE_SORT, bus::kSortTask);
  ASSERT_TRUE(shop.AwaitHealth(intaglio_HEALTH_READY));
  shop.worker().Kill();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(shop.AwaitGone());
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
}

TEST(ServiceHost, DiesWithItsParentOnRequest) {
  bus::Bus bus(test::PrivateBusOptions());
  bus::Reader<intaglio_ServiceHealth> health(bus, bus::kServiceHealth);
  // The shell starts the service and waits for it; then the shell is killed.
  ChildProgram shell("/bin/sh", {"-c", kSorter + " --die-with-parent --tag " +
                                           test::PrivateTag() + " & wait"});
  bool seen = false, gone = false;
  const auto period = [&] {
    health.TakeAll([&](const intaglio_ServiceHealth&, const bus::SampleOrigin& origin) {
      (origin.alive ? seen : gone) = true;
    });
  };
  ASSERT_TRUE(Eventually([&] { return period(), seen; }));
  shell.Kill();
  EXPECT_TRUE(Eventually([&] { return period(), gone; }));
}

// Killed between the start of the process and its first instruction.
TEST(ServiceHost, DoesNotBeginWithoutWhoStartedIt) {
  ChildProgram starter("/bin/true", {});
  const pid_t ended = starter.pid();
  ASSERT_EQ(starter.ExitCode(), 0);
  ChildProgram sorter(kSorter, {"--die-with-parent=" + std::to_string(ended), "--tag",
                                test::PrivateTag()});
  EXPECT_EQ(sorter.ExitCode(), 1);
}

TEST(PollLoop, WakesForSamplesForFilesAndOnRequest) {
  bus::Bus bus(test::PrivateBusOptions());
  bus::Reader<intaglio_Alarm> reader(bus, bus::kAlarm);
  bus::Writer<intaglio_Alarm> writer(bus, bus::kAlarm);
  ASSERT_TRUE(Eventually([&] { return writer.IsMatched(reader.guid()); }));
  int pipe_fds[2];
  ASSERT_EQ(pipe(pipe_fds), 0);
  PollLoop loop(bus);
  loop.Attach(reader);
  const auto wait_s = [&](std::chrono::milliseconds timeout) {
    const auto start = std::chrono::steady_clock::now();
    loop.Wait(std::array{pipe_fds[0], -1}, timeout);
    return std::chrono::steady_clock::now() - start;
  };
  EXPECT_GE(wait_s(20ms), 19ms);  // nothing there: the whole time, to the poll's 1 ms
  ASSERT_TRUE(writer.Write({}));
  EXPECT_LT(wait_s(5s), 4s);
  reader.Take([](const intaglio_Alarm&) {});
  ASSERT_EQ(write(pipe_fds[1], "x", 1), 1);
  EXPECT_LT(wait_s(5s), 4s);
  char byte;
  ASSERT_EQ(read(pipe_fds[0], &byte, 1), 1);
  loop.Wake();
  EXPECT_LT(wait_s(5s), 4s);
  close(pipe_fds[0]);
  close(pipe_fds[1]);
}

}  // namespace
}  // namespace intaglio::host
