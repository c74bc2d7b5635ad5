#include "services/recorder/recorder.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <variant>

#include "engrave/core/try.h"
#include "services/platform/bus/topic_tap.h"
#include "services/platform/bus/topics.h"
#include "services/platform/host/process/log.h"
#include "services/recorder/bulk_rule.h"
#include "services/recorder/live_scene.h"
#include "services/recorder/sequence_gaps.h"

namespace intaglio::recorder {
namespace {

using namespace std::chrono_literals;

constexpr auto kTurn = 100ms;
// Services that end together with this one report it within this time.
constexpr auto kDrainTime = 300ms;
constexpr auto kDrainTurn = 10ms;
// Lower in priority than every thread that computes or moves something.
constexpr int kWriterNice = 10;

std::uint64_t WallNow() {
  return static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch() /
                                    1ns);
}

std::uint64_t Unsigned(std::int64_t ns) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, ns));
}

recording::SampleKind KindOf(bus::TapKind kind) {
  switch (kind) {
    case bus::TapKind::kDisposed:
      return recording::SampleKind::kDisposed;
    case bus::TapKind::kNoWriter:
      return recording::SampleKind::kNoWriter;
    default:
      return recording::SampleKind::kValue;
  }
}

struct Unrecorded {
  std::string topic, why;
};
using Item = std::variant<bus::TapSample, recording::Attachment, Unrecorded>;

constexpr char kTooSlow[] = "the disk is too slow";
constexpr char kGaps[] = "gaps in their sequence numbers: they were not received";

/// Counts of messages that are not in the file.
struct Lost {
  std::uint32_t channel = 0;
  bus::TapKind kind = bus::TapKind::kValue;
  const char* reason = kTooSlow;

  auto operator<=>(const Lost&) const = default;
};

struct LostCount {
  std::uint64_t count = 0;
  std::uint64_t from_ns = 0, to_ns = 0;
};

}  // namespace

struct Recorder::Impl {
  Impl(bus::Bus& bus, const RecorderOptions& options, RecordingSeries&& files)
      : series(std::move(files)),
        queue(options.queue),
        bulk_rule(options.bulk),
        tap(
            bus,
            [filter = options.filter, rule = bulk_rule](const bus::TapChannel& channel) {
              return rule.Takes(channel.topic) &&
                     filter.Accepts(channel.topic, channel.partition, channel.type);
            },
            [this](const std::string& topic, const std::string& why) {
              host::LogWarning("{} is not recorded: {}", topic, why);
              (void)queue.Push(Unrecorded{topic, why}, 0, false);
            }) {
    if (options.scene) scene.emplace();
  }

  void Receive(const std::stop_token& stop) {
    const auto take = [this](std::chrono::milliseconds timeout) {
      return tap.Take(timeout,
                      [this](bus::TapSample&& sample) { HandOver(std::move(sample)); });
    };
    while (!stop.stop_requested()) take(kTurn);
    while (take(0ms) > 0) {  // what has come meanwhile
    }
  }
  void HandOver(bus::TapSample&& sample);
  void Write(const std::stop_token& stop);
  void WriteAll(std::vector<Item>&& items);
  void WriteOne(const bus::TapSample& sample);
  void Attach(recording::Attachment attachment);
  std::uint32_t StreamOf(std::uint32_t channel, bus::TapKind kind);
  void CountLost(const Lost& what, std::uint64_t received_ns, std::uint64_t count);
  void LogLost();
  void Publish();

  RecordingSeries series;  // of the writer thread
  WriteQueue<Item> queue;
  BulkRule bulk_rule;  // of the receiving thread
  bus::TopicTap tap;
  std::map<std::pair<std::uint32_t, bus::TapKind>, std::uint32_t> streams;  // of it, too
  std::optional<LiveScene> scene;                                           // of it, too
  SequenceGaps gaps;  // of the receiving thread
  std::mutex lost_mutex;
  std::map<Lost, LostCount> lost;
  mutable std::mutex state_mutex;
  State state;
  std::jthread receiving, writing;
};

void Recorder::Impl::HandOver(bus::TapSample&& sample) {
  const bus::TapChannel& from = tap.channel(sample.channel());
  const std::uint64_t received_ns = Unsigned(sample.received_ns());
  if (sample.kind() == bus::TapKind::kValue) {
    const std::uint64_t missing =
        gaps.Before(sample.channel(), from.type, sample.bytes());
    if (missing > 0)
      CountLost({sample.channel(), sample.kind(), kGaps}, received_ns, missing);
  }
  if (!bulk_rule.Keeps(from.topic, sample.channel())) return;
  const bool bulk = from.domain == bus::DomainKind::kBulk;
  const std::uint64_t bytes = sample.bytes().size() + sizeof(Item);
  const Lost refused{sample.channel(), sample.kind(), kTooSlow};
  Item item(std::move(sample));
  if (!queue.Push(std::move(item), bytes, bulk)) CountLost(refused, received_ns, 1);
}

void Recorder::Impl::CountLost(const Lost& what, std::uint64_t received_ns,
                               std::uint64_t count) {
  const std::lock_guard lock(lost_mutex);
  LostCount& entry = lost[what];
  if (entry.count == 0) entry.from_ns = received_ns;
  entry.count += count;
  entry.to_ns = received_ns;
}

std::uint32_t Recorder::Impl::StreamOf(std::uint32_t channel, bus::TapKind kind) {
  const auto [known, added] = streams.try_emplace({channel, kind}, 0);
  if (added) {
    const bus::TapChannel& received = tap.channel(channel);
    known->second = series.AddStream(
        {received.topic, received.type, received.domain == bus::DomainKind::kBulk,
         received.partition, KindOf(kind), received.keyed, received.qos},
        {received.idl, received.key_idl, received.recipe});
  }
  return known->second;
}

void Recorder::Impl::WriteOne(const bus::TapSample& sample) {
  const std::uint64_t received_ns = Unsigned(sample.received_ns());
  series.Write(StreamOf(sample.channel(), sample.kind()), received_ns,
               Unsigned(sample.source_ns()), sample.bytes());
  if (!scene || sample.kind() != bus::TapKind::kValue) return;
  const bus::TapChannel& from = tap.channel(sample.channel());
  scene->Add({from.topic, from.type, from.idl, from.partition}, sample.bytes(),
             received_ns, series);
}

void Recorder::Impl::Attach(recording::Attachment attachment) {
  if (scene) scene->Add(attachment);
  series.Attach(std::move(attachment));
}

void Recorder::Impl::WriteAll(std::vector<Item>&& items) {
  for (Item& item : items) {
    if (const auto* sample = std::get_if<bus::TapSample>(&item)) {
      WriteOne(*sample);
    } else if (auto* attachment = std::get_if<recording::Attachment>(&item)) {
      Attach(std::move(*attachment));
    } else if (const auto* unrecorded = std::get_if<Unrecorded>(&item)) {
      series.ReportUnrecorded(unrecorded->topic, unrecorded->why);
    }
  }
}

void Recorder::Impl::LogLost() {
  std::map<Lost, LostCount> reported;
  {
    const std::lock_guard lock(lost_mutex);
    reported.swap(lost);
  }
  for (const auto& [what, entry] : reported) {
    const std::uint32_t stream = StreamOf(what.channel, what.kind);
    series.CountMissing(stream, entry.from_ns, what.reason, entry.count);
    series.CountMissing(stream, entry.to_ns, what.reason, 0);
  }
}

void Recorder::Impl::Publish() {
  const std::lock_guard lock(state_mutex);
  state = {series.file().string(), series.message_count(), series.missing_count(),
           series.trouble()};
}

void Recorder::Impl::Write(const std::stop_token& stop) {
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kWriterNice);
  while (!stop.stop_requested()) {
    WriteAll(queue.Take(kTurn));
    LogLost();
    series.Turn(WallNow());
    Publish();
  }
  WriteAll(queue.Take(0ms));
  if (scene) scene->Finish(series);
  LogLost();
}

Recorder::Recorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recorder::~Recorder() {
  impl_->receiving.request_stop();
  impl_->writing.request_stop();
}

Result<std::unique_ptr<Recorder>> Recorder::Start(bus::Bus& bus,
                                                  const RecorderOptions& options) {
  SeriesOptions about = options.series;
  about.bulk = BulkRule(options.bulk).request();
  auto series = INTAGLIO_TRY(RecordingSeries::Open(about, WallNow()));
  auto impl = std::make_unique<Impl>(bus, options, std::move(series));
  Impl* const shared = impl.get();
  shared->Publish();
  shared->receiving =
      std::jthread([shared](const std::stop_token& stop) { shared->Receive(stop); });
  shared->writing =
      std::jthread([shared](const std::stop_token& stop) { shared->Write(stop); });
  return std::unique_ptr<Recorder>(new Recorder(std::move(impl)));
}

void Recorder::Turn(std::chrono::milliseconds timeout) { impl_->tap.Discover(timeout); }

void Recorder::Attach(recording::Attachment attachment) {
  const std::uint64_t bytes = attachment.content.size();
  (void)impl_->queue.Push(std::move(attachment), bytes, false);
}

Status Recorder::Stop() {
  // A service writes its health as long as it runs, and ends when all that it wrote is
  // acknowledged. This one's own writer of it is the last.
  const auto end = std::chrono::steady_clock::now() + kDrainTime;
  const auto others_run = [this] {
    return impl_->tap.WriterCount(bus::kServiceHealth.name).value_or(2) > 1;
  };
  while (others_run() && std::chrono::steady_clock::now() < end) Turn(kDrainTurn);
  impl_->receiving.request_stop();
  impl_->tap.Wake();
  impl_->receiving.join();
  impl_->writing.request_stop();
  impl_->writing.join();
  auto closed = impl_->series.Close();
  impl_->Publish();
  return closed;
}

Recorder::State Recorder::state() const {
  const std::lock_guard lock(impl_->state_mutex);
  return impl_->state;
}

}  // namespace intaglio::recorder
