#include "services/platform/bus/bus.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "services/platform/bus/samples.h"
#include "services/platform/bus/topics.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::bus {
namespace {

using namespace std::chrono_literals;
using test::Eventually;
using test::PrivateBusOptions;
using testing::ElementsAre;

TEST(Bus, EveryTopicMakesItsWayFromOneBusToAnother) {
  Bus sender(PrivateBusOptions("cell-a")), receiver(PrivateBusOptions("cell-a"));
  bus::ForEachTopic([&](const auto& topic) {
    using Sample = typename std::decay_t<decltype(topic)>::Sample;
    Reader<Sample> reader(receiver, topic);
    Writer<Sample> writer(sender, topic);
    ASSERT_TRUE(Eventually([&] {
      return writer.IsMatched(reader.guid()) && reader.matched_count() == 1;
    })) << topic.name;
    ASSERT_TRUE(writer.Write(Sample{})) << topic.name;
    int taken = 0;
    EXPECT_TRUE(Eventually([&] {
      reader.Take([&taken](const Sample&) { ++taken; });
      return taken == 1;
    })) << topic.name;
  });
}

/// How many receiving threads the library has in this process: one for each domain.
int ReceivingThreads() {
  int count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream in(task.path() / "comm");
    std::string name;
    std::getline(in, name);
    if (name.starts_with("recv")) ++count;
  }
  return count;
}

TEST(Bus, JoinsTheBulkDomainAtItsFirstBulkTopic) {
  ASSERT_EQ(ReceivingThreads(), 0) << "no other test may have left its bus";
  Bus bus(PrivateBusOptions());
  const Reader<intaglio_JobStatus> control(bus, kJobStatus);
  EXPECT_TRUE(Eventually([] { return ReceivingThreads() == 1; })) << ReceivingThreads();
  const Reader<intaglio_PointBatch> points(bus, kPointBatch);
  EXPECT_TRUE(Eventually([] { return ReceivingThreads() == 2; })) << ReceivingThreads();
  const Reader<intaglio_PathBatch> paths(bus, kPathBatch);
  EXPECT_TRUE(Eventually([] { return ReceivingThreads() == 2; })) << ReceivingThreads();
}

TEST(Bus, KeepsWhatIsInABatch) {
  Bus bus(PrivateBusOptions());
  Reader<intaglio_PointBatch> reader(bus, kPointBatch);
  Writer<intaglio_PointBatch> writer(bus, kPointBatch);
  ASSERT_TRUE(Eventually([&] { return writer.IsMatched(reader.guid()); }));

  const std::string job_uid = "7-1f";
  const std::vector<double> x = {1.5, -2.25}, y = {1e-300, 3}, z = {0.1, -0.0};
  const std::vector<std::uint32_t> source = {0, 0xffffffffu};
  intaglio_PointBatch batch{};
  batch.job_uid = Borrow(job_uid);
  batch.attempt = 3;
  batch.sequence_number = 1ull << 40;
  batch.last = true;
  Borrow(batch.x_mm, x);
  Borrow(batch.y_mm, y);
  Borrow(batch.z_mm, z);
  Borrow(batch.source, source);
  ASSERT_TRUE(writer.Write(batch));

  WaitSet wait(bus);
  wait.Attach(reader);
  ASSERT_TRUE(wait.Wait(5s));
  int taken = 0;
  reader.Take([&](const intaglio_PointBatch& got) {
    ++taken;
    EXPECT_EQ(View(got.job_uid), job_uid);
    EXPECT_EQ(got.attempt, 3u);
    EXPECT_EQ(got.sequence_number, 1ull << 40);
    EXPECT_TRUE(got.last);
    EXPECT_TRUE(std::ranges::equal(View(got.x_mm), x));
    EXPECT_TRUE(std::ranges::equal(View(got.y_mm), y));
    EXPECT_TRUE(std::ranges::equal(View(got.z_mm), z));
    EXPECT_TRUE(std::signbit(View(got.z_mm)[1])) << "minus zero stays what it is";
    EXPECT_TRUE(std::ranges::equal(View(got.source), source));
  });
  EXPECT_EQ(taken, 1);
}

intaglio_JobStatus StatusOf(const std::string& job_uid, std::uint64_t revision) {
  intaglio_JobStatus status{};
  status.job_uid = Borrow(job_uid);
  status.revision = revision;
  return status;
}

// Who writes faster than a reader takes does not keep that for ever.
TEST(Bus, OneTakeIsBoundedAndTheNextTakesTheRest) {
  Bus bus(PrivateBusOptions());
  Writer<intaglio_TaskStatus> writer(bus, kTaskStatus);
  Reader<intaglio_TaskStatus> reader(bus, kTaskStatus, {}, Source::kEverybody,
                                     Keeps::kEverySample);
  const std::string name = "one";
  intaglio_TaskStatus sample{};
  sample.job_uid = sample.worker = sample.message = Borrow(name);
  constexpr int kSamples = 20'000;
  for (int i = 0; i < kSamples; ++i) {
    sample.done_count = static_cast<std::uint64_t>(i);
    ASSERT_TRUE(writer.Write(sample));
  }
  int taken = 0;
  const auto count = [&](const intaglio_TaskStatus& status) {
    EXPECT_EQ(status.done_count, static_cast<std::uint64_t>(taken++));
  };
  EXPECT_EQ(reader.Take(count), 16384);
  EXPECT_EQ(reader.Take(count), kSamples - 16384);
}

TEST(Bus, LateJoinerGetsTheNewestStateOfEachInstance) {
  Bus bus(PrivateBusOptions());
  Writer<intaglio_JobStatus> writer(bus, kJobStatus);
  const std::string a = "a", b = "b";
  for (std::uint64_t revision = 1; revision <= 5; ++revision) {
    ASSERT_TRUE(writer.Write(StatusOf(a, revision)));
  }
  ASSERT_TRUE(writer.Write(StatusOf(b, 1)));

  Bus late(PrivateBusOptions());
  Reader<intaglio_JobStatus> reader(late, kJobStatus);
  std::map<std::string, std::uint64_t> revisions;
  int taken = 0;
  EXPECT_TRUE(Eventually([&] {
    taken += reader.Take([&revisions](const intaglio_JobStatus& status) {
      revisions[std::string(View(status.job_uid))] = status.revision;
    });
    return revisions.size() == 2;
  }));
  EXPECT_EQ(revisions["a"], 5u);
  EXPECT_EQ(revisions["b"], 1u);
  EXPECT_EQ(taken, 2) << "older revisions are not kept";
}

TEST(Bus, AnInstanceEndsWhenItIsDisposed) {
  Bus bus(PrivateBusOptions());
  Reader<intaglio_JobStatus> reader(bus, kJobStatus);
  Writer<intaglio_JobStatus> writer(bus, kJobStatus);
  ASSERT_TRUE(Eventually([&] { return writer.IsMatched(reader.guid()); }));
  const std::string a = "a";
  std::vector<std::string> events;
  const auto take = [&] {
    reader.TakeAll([&events](const intaglio_JobStatus& status,
                             const SampleOrigin& origin) {
      events.push_back(std::string(View(status.job_uid)) + (origin.alive ? "+" : "-"));
    });
  };
  ASSERT_TRUE(writer.Write(StatusOf(a, 1)));
  EXPECT_TRUE(Eventually([&] { return take(), events.size() == 1; }));
  ASSERT_TRUE(writer.Dispose(StatusOf(a, 1)));
  EXPECT_TRUE(Eventually([&] { return take(), events.size() == 2; }));
  EXPECT_THAT(events, ElementsAre("a+", "a-"));
}

// A request of a client that is gone before the service reads it still counts.
TEST(Bus, TheLastSampleOfAGoneWriterIsNotLost) {
  Bus bus(PrivateBusOptions());
  Reader<intaglio_JobStatus> reader(bus, kJobStatus);
  const std::string a = "a";
  {
    Writer<intaglio_JobStatus> writer(bus, kJobStatus);
    ASSERT_TRUE(Eventually([&] { return writer.IsMatched(reader.guid()); }));
    ASSERT_TRUE(writer.Write(StatusOf(a, 9)));
  }
  std::vector<std::string> events;
  reader.TakeAll([&events](const intaglio_JobStatus& status, const SampleOrigin& origin) {
    events.push_back(std::string(View(status.job_uid)) + (origin.alive ? "+" : "-"));
  });
  EXPECT_THAT(events, ElementsAre("a+", "a-"));
}

TEST(Bus, KeylessSamplesOutliveTheirWriter) {
  Bus bus(PrivateBusOptions());
  Reader<intaglio_Alarm> reader(bus, kAlarm);
  {
    Writer<intaglio_Alarm> writer(bus, kAlarm);
    ASSERT_TRUE(Eventually([&] { return writer.IsMatched(reader.guid()); }));
    for (std::uint64_t i = 0; i < 100; ++i) {
      intaglio_Alarm alarm{};
      alarm.sequence_number = i;
      ASSERT_TRUE(writer.Write(alarm));
    }
  }
  std::uint64_t expected = 0;
  reader.Take([&expected](const intaglio_Alarm& alarm) {
    EXPECT_EQ(alarm.sequence_number, expected++);
  });
  EXPECT_EQ(expected, 100u);
}

TEST(Bus, CellTopicsStayInTheirCell) {
  Bus a(PrivateBusOptions("a")), b(PrivateBusOptions("b")),
      everybody(PrivateBusOptions());
  Writer<intaglio_Interlock> writer(a, kInterlock);
  Reader<intaglio_Interlock> in_a(a, kInterlock), in_b(b, kInterlock),
      all(everybody, kInterlock), asked_to(b, kInterlock, "a");
  ASSERT_TRUE(Eventually([&] {
    return writer.IsMatched(in_a.guid()) && writer.IsMatched(all.guid()) &&
           writer.IsMatched(asked_to.guid());
  }));
  EXPECT_FALSE(writer.IsMatched(in_b.guid()));
  EXPECT_EQ(in_b.matched_count(), 0);
}

TEST(Bus, WaitSetWakesAcrossBothDomainsAndOnRequest) {
  Bus bus(PrivateBusOptions());
  Reader<intaglio_ModelChunk> bulk(bus, kModelChunk);
  Reader<intaglio_Alarm> control(bus, kAlarm);
  Writer<intaglio_ModelChunk> bulk_writer(bus, kModelChunk);
  Writer<intaglio_Alarm> control_writer(bus, kAlarm);
  WaitSet wait(bus);
  wait.Attach(bulk);
  wait.Attach(control);
  EXPECT_FALSE(wait.Wait(0ms));
  ASSERT_TRUE(Eventually([&] {
    return bulk_writer.IsMatched(bulk.guid()) && control_writer.IsMatched(control.guid());
  }));

  ASSERT_TRUE(bulk_writer.Write({}));
  EXPECT_TRUE(wait.Wait(5s));
  bulk.Take([](const intaglio_ModelChunk&) {});
  EXPECT_FALSE(wait.Wait(0ms));
  ASSERT_TRUE(control_writer.Write({}));
  EXPECT_TRUE(wait.Wait(5s));
  control.Take([](const intaglio_Alarm&) {});

  std::jthread waker([&wait] { wait.Wake(); });
  EXPECT_TRUE(wait.Wait(5s));
  EXPECT_FALSE(wait.Wait(0ms)) << "one Wake, one return";
}

TEST(Bus, AnUnwrittenSafetyTopicMissesDeadlineAndLease) {
  Bus bus(PrivateBusOptions("cell"));
  Reader<intaglio_Permission> reader(bus, kPermission);
  Writer<intaglio_Permission> writer(bus, kPermission);
  ASSERT_TRUE(Eventually([&] { return writer.IsMatched(reader.guid()); }));
  ASSERT_TRUE(writer.Write({}));
  ASSERT_TRUE(Eventually([&] { return reader.events().alive_writers == 1; }));
  // 250 ms lease and 200 ms deadline; ten times that is for a loaded machine.
  int lost = 0, missed = 0;
  EXPECT_TRUE(Eventually(
      [&] {
        const ReaderEvents events = reader.events();
        lost += events.lost_leases;
        missed += events.missed_deadlines;
        return lost > 0 && missed > 0;
      },
      2500ms));
}

TEST(Bus, WrongOptionsAreRefusedWithTheirValue) {
  BusOptions options = PrivateBusOptions();
  options.interface = "no-such-interface";
  options.control_domain = 60;
  try {
    Bus bus(options);
    FAIL() << "an interface that does not exist was accepted";
  } catch (const BusError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("no-such-interface"));
  }
  options = PrivateBusOptions();
  options.control_domain = 100;
  EXPECT_THROW(Bus{options}, BusError);
  options = PrivateBusOptions();
  options.tag = "<";
  EXPECT_THROW(Bus{options}, BusError);
  EXPECT_NO_THROW(Bus{PrivateBusOptions()}) << "a refused one leaves nothing behind";
}

}  // namespace
}  // namespace intaglio::bus
