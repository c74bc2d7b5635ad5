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
#include "services/platform/host/process/log.h"
#include "services/recorder/bulk_rule.h"

namespace intaglio::recorder {
namespace {

using namespace std::chrono_literals;

constexpr auto kTurn = 100ms;
// Services that end together with this one report it within this time.
constexpr auto kDrainTime = 300ms;
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

/// What was refused at the queue, one entry a channel and kind.
struct Refused {
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
            }) {}

  void Receive(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      tap.Take(kTurn, [this](bus::TapSample&& sample) { HandOver(std::move(sample)); });
    }
  }
  void HandOver(bus::TapSample&& sample);
  void Write(const std::stop_token& stop);
  void WriteAll(std::vector<Item>&& items);
  void WriteOne(const bus::TapSample& sample);
  std::uint32_t StreamOf(std::uint32_t channel, bus::TapKind kind);
  void LogRefused();
  void Publish();

  RecordingSeries series;  // of the writer thread
  WriteQueue<Item> queue;
  BulkRule bulk_rule;  // of the receiving thread
  bus::TopicTap tap;
  std::map<std::pair<std::uint32_t, bus::TapKind>, std::uint32_t> streams;  // of it, too
  std::mutex refused_mutex;
  std::map<std::pair<std::uint32_t, bus::TapKind>, Refused> refused;
  mutable std::mutex state_mutex;
  State state;
  std::jthread receiving, writing;
};

void Recorder::Impl::HandOver(bus::TapSample&& sample) {
  const bus::TapChannel& from = tap.channel(sample.channel());
  if (!bulk_rule.Keeps(from.topic, sample.channel())) return;
  const bool bulk = from.domain == bus::DomainKind::kBulk;
  const std::uint64_t bytes = sample.bytes().size() + sizeof(Item);
  const std::pair key(sample.channel(), sample.kind());
  const std::uint64_t received_ns = Unsigned(sample.received_ns());
  Item item(std::move(sample));
  if (queue.Push(std::move(item), bytes, bulk)) return;
  const std::lock_guard lock(refused_mutex);
  Refused& entry = refused[key];
  if (entry.count++ == 0) entry.from_ns = received_ns;
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
  series.Write(StreamOf(sample.channel(), sample.kind()), Unsigned(sample.received_ns()),
               Unsigned(sample.source_ns()), sample.bytes());
}

void Recorder::Impl::WriteAll(std::vector<Item>&& items) {
  for (Item& item : items) {
    if (const auto* sample = std::get_if<bus::TapSample>(&item)) {
      WriteOne(*sample);
    } else if (auto* attachment = std::get_if<recording::Attachment>(&item)) {
      series.Attach(std::move(*attachment));
    } else if (const auto* unrecorded = std::get_if<Unrecorded>(&item)) {
      series.ReportUnrecorded(unrecorded->topic, unrecorded->why);
    }
  }
}

void Recorder::Impl::LogRefused() {
  std::map<std::pair<std::uint32_t, bus::TapKind>, Refused> reported;
  {
    const std::lock_guard lock(refused_mutex);
    reported.swap(refused);
  }
  for (const auto& [key, entry] : reported) {
    const std::uint32_t stream = StreamOf(key.first, key.second);
    series.CountMissing(stream, entry.from_ns, "the disk is too slow", entry.count);
    series.CountMissing(stream, entry.to_ns, "the disk is too slow", 0);
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
    LogRefused();
    series.Turn(WallNow());
    Publish();
  }
  WriteAll(queue.Take(0ms));
  LogRefused();
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
  const auto end = std::chrono::steady_clock::now() + kDrainTime;
  while (std::chrono::steady_clock::now() < end) Turn(20ms);
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
