#include "services/replayer/player.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>
#include <tuple>

#include "engrave/core/try.h"
#include "services/platform/recording/message_cursor.h"

namespace intaglio::replayer {
namespace {

/// 30 years: no clock overflows, whatever times a file has.
constexpr double kLongestWaitNs = 1e18;

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kSlice = 20ms;
// Credit comes within fractions of a millisecond when the consumer is idle.
constexpr auto kCreditPeriod = 200us;

bus::CdrKind KindOf(recording::SampleKind kind) {
  switch (kind) {
    case recording::SampleKind::kDisposed:
      return bus::CdrKind::kDisposed;
    case recording::SampleKind::kNoWriter:
      return bus::CdrKind::kNoWriter;
    default:
      return bus::CdrKind::kValue;
  }
}

std::uint64_t EndOf(const recording::McapReader& reader) {
  return reader.contents().statistics.end_ns;
}

}  // namespace

Player::Player(bus::Bus& bus, const recording::McapReader& reader, Selection selection)
    : reader_(reader), selection_(std::move(selection)), gate_(bus) {}

Result<std::unique_ptr<Player>> Player::Make(bus::Bus& bus, bus::CdrPublisher& publisher,
                                             const recording::McapReader& reader,
                                             Selection selection) {
  std::unique_ptr<Player> player(new Player(bus, reader, std::move(selection)));
  INTAGLIO_TRY(player->MakeWriters(publisher));
  return player;
}

Status Player::MakeWriters(bus::CdrPublisher& publisher) {
  const auto records = INTAGLIO_TRY(reader_.ReadMetadata(recording::kTypeRecord));
  std::map<std::string, const bus::TypeRecipe*> recipes;
  for (const recording::Metadata& record : records) {
    const auto name = record.entries.find("name");
    if (name != record.entries.end()) recipes.emplace(name->second, &record.entries);
  }
  std::map<std::tuple<bool, std::string, std::string>, bus::CdrWriter*> made;
  for (const auto& [id, channel] : selection_.channels) {
    const recording::Stream& stream = channel.stream;
    auto& writer = made[{stream.bulk, channel.name, stream.partition}];
    if (writer == nullptr) {
      const auto recipe = recipes.find(stream.type);
      if (recipe == recipes.end()) {
        return Fail(ErrorCode::kMissing,
                    fmt::format("{}: the recording does not contain its type {}; leave "
                                "it out with --without-topic {}",
                                stream.topic, stream.type, stream.topic),
                    stream.topic);
      }
      auto fresh = INTAGLIO_TRY(publisher.MakeWriter(
          {stream.bulk ? bus::DomainKind::kBulk : bus::DomainKind::kControl, channel.name,
           stream.partition, stream.qos},
          *recipe->second));
      writer = fresh.get();
      writers_.push_back(std::move(fresh));
    }
    writer_of_[id] = writer;
  }
  return {};
}

bool Player::WaitUntil(Clock::time_point due, const PlayHooks& hooks) const {
  for (;;) {
    if (!hooks.keep_on()) return false;
    const auto now = Clock::now();
    if (now >= due) return true;
    std::this_thread::sleep_until(std::min(due, now + kSlice));
  }
}

bool Player::WaitForCredit(const PlayedChannel& channel, const bus::CdrWriter& writer,
                           recording::ByteView payload, const PlayHooks& hooks) {
  if (channel.stream.kind != recording::SampleKind::kValue) return true;
  const auto place = PlaceOf(channel.name, payload);
  if (!place) return true;
  while (!gate_.MayGo(*place, writer, Clock::now())) {
    if (!hooks.keep_on()) return false;
    std::this_thread::sleep_for(kCreditPeriod);
  }
  return true;
}

bool Player::Write(std::uint16_t channel_id, std::uint64_t publish_time_ns,
                   recording::ByteView payload, const PlayHooks& hooks,
                   PlayReport& report) {
  const PlayedChannel& channel = selection_.channels.at(channel_id);
  for (;;) {
    const auto written = writer_of_.at(channel_id)
                             ->Write(KindOf(channel.stream.kind), payload,
                                     static_cast<std::int64_t>(publish_time_ns));
    if (written) return true;
    if (written.error().code != ErrorCode::kTimedOut) {
      report.complaints.push_back(written.error().message);
      return false;
    }
    if (!hooks.keep_on()) return false;
  }
}

void Player::Restore(const PlayOptions& options, const PlayHooks& hooks,
                     PlayReport& report) {
  Retained retained(reader_, selection_);
  for (const recording::RetainedSample& sample : retained.Before(options.from_ns)) {
    if (Write(static_cast<std::uint16_t>(sample.stream), sample.publish_time_ns,
              sample.payload, hooks, report))
      ++report.restored_count;
  }
  report.complaints.insert(report.complaints.end(), retained.complaints().begin(),
                           retained.complaints().end());
}

PlayReport Player::Play(const PlayOptions& options, const PlayHooks& hooks) {
  PlayReport report;
  const std::uint64_t start_ns =
      std::max(options.from_ns, reader_.contents().statistics.start_ns);
  if (options.from_ns > reader_.contents().statistics.start_ns)
    Restore(options, hooks, report);
  std::set<std::uint16_t> channels;
  for (const auto& [id, channel] : selection_.channels) channels.insert(id);
  recording::MessageCursor cursor(
      reader_,
      {.from_ns = options.from_ns, .to_ns = options.to_ns, .channels = channels});
  const auto began = Clock::now();
  const auto due = [&](std::uint64_t log_time_ns) {
    if (options.by_credit) return began;
    const double after_ns = static_cast<double>(log_time_ns - start_ns) / options.rate;
    return began + std::chrono::nanoseconds(
                       static_cast<std::int64_t>(std::min(after_ns, kLongestWaitNs)));
  };
  for (;;) {
    const auto message = cursor.Next();
    if (!message) {
      report.complaints.push_back(message.error().message);
      continue;
    }
    if (!*message) break;
    const recording::MessageView& view = **message;
    const PlayedChannel& channel = selection_.channels.at(view.channel_id);
    if (!WaitUntil(due(view.log_time_ns), hooks)) return report;
    if (hooks.admit && !hooks.admit(channel, view.log_time_ns)) return report;
    if (options.by_credit &&
        !WaitForCredit(channel, *writer_of_.at(view.channel_id), view.payload, hooks))
      return report;
    if (Write(view.channel_id, view.publish_time_ns, view.payload, hooks, report))
      ++(channel.stream.repeated ? report.restored_count : report.played_count);
  }
  // Silence at the end is part of it.
  report.whole = WaitUntil(
      due(std::max(start_ns,
                   std::min(options.to_ns.value_or(EndOf(reader_)), EndOf(reader_)))),
      hooks);
  return report;
}

void Player::Settle(std::chrono::milliseconds timeout) {
  const auto end = Clock::now() + timeout;
  for (const auto& writer : writers_) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    (void)writer->WaitForAcknowledgements(std::max(left, 1ms));
  }
}

}  // namespace intaglio::replayer
