#include "services/recorder/recording_series.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "services/recorder/series_files.h"

namespace intaglio::recorder {
namespace {

using recording::Lane;
using recording::Metadata;

// Control that waits for a disk that refuses; an hour of a busy cell.
constexpr std::uint64_t kMaxWaitingBytes = 64u << 20;
constexpr std::uint64_t kQuietNs = 1'000'000'000;
constexpr std::uint64_t kLongSpanNs = 5'000'000'000;
constexpr std::uint64_t kSyncPeriodNs = 200'000'000;

std::string UtcText(std::uint64_t ns) {
  const auto seconds = static_cast<std::time_t>(ns / 1'000'000'000);
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(seconds));
}

}  // namespace

Result<RecordingSeries> RecordingSeries::Open(const SeriesOptions& options,
                                              std::uint64_t now_ns) {
  RecordingSeries series(options, now_ns);
  const auto there = FilesOf(options.file);
  series.file_number_ = there.empty() ? 0 : there.back().number;
  if (auto opened = series.OpenNext(now_ns); !opened) {
    return tl::unexpected(opened.error());
  }
  return series;
}

Status RecordingSeries::OpenNext(std::uint64_t now_ns) {
  recording::WriterOptions writer_options = options_.writer;
  writer_options.library = "intaglio " + options_.version;
  auto writer = recording::McapWriter::Create(PathOf(options_.file, file_number_ + 1),
                                              writer_options);
  if (!writer) return tl::unexpected(writer.error());
  ++file_number_;
  writer_ = std::move(*writer);
  file_began_ns_ = now_ns;
  for (Known& known : streams_) known.channel.reset();
  stream_of_channel_.clear();
  types_written_.clear();
  attachments_written_ = unrecorded_written_ = 0;
  Note(writer_->Write(Metadata{recording::kRecordingRecord,
                               {{"version", options_.version},
                                {"host", options_.host},
                                {"started_utc", UtcText(now_ns)},
                                {"file_number", std::to_string(file_number_)}}}));
  WritePending();
  return {};
}

std::uint32_t RecordingSeries::AddStream(const recording::Stream& stream,
                                         const StreamTypes& types) {
  for (std::uint32_t i = 0; i < streams_.size(); ++i) {
    if (streams_[i].stream == stream) return i;
  }
  streams_.push_back({stream, types, std::nullopt, 0});
  return static_cast<std::uint32_t>(streams_.size() - 1);
}

void RecordingSeries::Define(Known& known) {
  const auto& [stream, types, channel, sequence] = known;
  const bool value = stream.kind == recording::SampleKind::kValue;
  const std::string& idl = value ? types.idl : types.key_idl;
  recording::Channel made = recording::ChannelOf(stream);
  made.schema_id = writer_->AddSchema(value ? stream.type : stream.type + "_key",
                                      idl.empty() ? "" : recording::kOmgIdl, idl);
  known.channel =
      writer_->AddChannel(std::move(made), stream.bulk ? Lane::kLarge : Lane::kSmall);
  stream_of_channel_[*known.channel] =
      static_cast<std::uint32_t>(&known - streams_.data());
  const bool told = std::find(types_written_.begin(), types_written_.end(),
                              stream.type) != types_written_.end();
  if (told || types.recipe.empty()) return;
  const auto written = writer_->Write(Metadata{recording::kTypeRecord, types.recipe});
  if (written) types_written_.push_back(stream.type);
  Note(written);
}

void RecordingSeries::Write(std::uint32_t stream, std::uint64_t log_time_ns,
                            std::uint64_t publish_time_ns, recording::ByteView payload) {
  Known& known = streams_.at(stream);
  if (trouble_ && known.stream.bulk) {
    CountMissing(stream, log_time_ns, "the disk refused");
    return;
  }
  if (!known.channel) Define(known);
  ++message_count_;
  Note(writer_->Write(recording::MessageView{*known.channel, known.sequence++,
                                             log_time_ns, publish_time_ns, payload}));
  if (trouble_ && writer_->gathered_bytes(Lane::kSmall) > kMaxWaitingBytes) {
    GiveUp(Lane::kSmall, "the disk refused for too long");
  }
}

// Bulk is given up at once: it would fill the memory within seconds.
void RecordingSeries::Note(const Status& written) {
  if (written) return;
  trouble_ = written.error();
  GiveUp(Lane::kLarge, "the disk refused");
}

void RecordingSeries::GiveUp(Lane lane, const char* reason) {
  for (const auto& [channel, dropped] : writer_->Drop(lane)) {
    const std::uint32_t stream = stream_of_channel_.at(channel);
    CountMissing(stream, dropped.from_ns, reason, dropped.count);
    CountMissing(stream, dropped.to_ns, reason, 0);
    message_count_ -= dropped.count;
  }
}

void RecordingSeries::CountMissing(std::uint32_t stream, std::uint64_t log_time_ns,
                                   const std::string& reason, std::uint64_t count) {
  Missing& missing = missing_[{stream, reason}];
  missing.from_ns =
      missing.count == 0 ? log_time_ns : std::min(missing.from_ns, log_time_ns);
  missing.to_ns = std::max(missing.to_ns, log_time_ns);
  missing.count += count;
  missing_count_ += count;
}

void RecordingSeries::TellUnrecorded(const std::string& topic,
                                     const std::string& reason) {
  unrecorded_.push_back(
      {recording::kMissingRecord, {{"topic", topic}, {"reason", reason}}});
}

void RecordingSeries::Attach(recording::Attachment attachment) {
  attachments_.push_back(std::move(attachment));
  WritePending();
}

void RecordingSeries::WritePending() {
  while (!trouble_ && attachments_written_ < attachments_.size()) {
    const auto written = writer_->Write(attachments_[attachments_written_]);
    if (written) ++attachments_written_;
    Note(written);
  }
  while (!trouble_ && unrecorded_written_ < unrecorded_.size()) {
    const auto written = writer_->Write(unrecorded_[unrecorded_written_]);
    if (written) ++unrecorded_written_;
    Note(written);
  }
}

// A span of missing messages is told when it is over, or has lasted: one record instead
// of many.
void RecordingSeries::WriteMissing(std::uint64_t now_ns) {
  for (auto entry = missing_.begin(); !trouble_ && entry != missing_.end();) {
    const auto& [key, missing] = *entry;
    if (now_ns < missing.to_ns + kQuietNs && now_ns < missing.from_ns + kLongSpanNs) {
      ++entry;
      continue;
    }
    const recording::Stream& stream = streams_[key.first].stream;
    const auto written =
        writer_->Write(Metadata{recording::kMissingRecord,
                                {{"topic", stream.topic},
                                 {"domain", stream.bulk ? "bulk" : "control"},
                                 {"partition", stream.partition},
                                 {"sample", recording::NameOf(stream.kind)},
                                 {"count", std::to_string(missing.count)},
                                 {"from_ns", std::to_string(missing.from_ns)},
                                 {"to_ns", std::to_string(missing.to_ns)},
                                 {"reason", key.second}}});
    Note(written);
    if (written) entry = missing_.erase(entry);
  }
}

void RecordingSeries::Turn(std::uint64_t now_ns) {
  const auto written = trouble_ ? writer_->Flush() : writer_->FlushIfOld(now_ns);
  if (written) trouble_.reset();
  Note(written);
  WritePending();
  WriteMissing(now_ns);
  SyncIfDue(now_ns);
  const bool full =
      options_.split_bytes > 0 && writer_->file_bytes() >= options_.split_bytes;
  const bool long_enough =
      options_.split_ns > 0 && now_ns >= file_began_ns_ + options_.split_ns;
  if (!trouble_ && (full || long_enough)) BeginNext(now_ns);
}

// As seldom at full speed as when little is said: a disk takes its time for it. A clock
// that was set back begins anew.
void RecordingSeries::SyncIfDue(std::uint64_t now_ns) {
  const bool early = now_ns >= synced_ns_ && now_ns < synced_ns_ + kSyncPeriodNs;
  if (trouble_ || early || writer_->synced_bytes() == writer_->file_bytes()) return;
  synced_ns_ = now_ns;
  Note(writer_->Sync());
}

// The old file is left only when the new one is there.
void RecordingSeries::BeginNext(std::uint64_t now_ns) {
  const auto flushed = writer_->Flush();
  Note(flushed);
  if (!flushed) return;
  recording::McapWriter before = std::move(*writer_);
  auto opened = OpenNext(now_ns);
  if (!opened) {
    writer_ = std::move(before);
    Note(opened);
    return;
  }
  auto closed = before.Close();
  if (closed) closed = before.Sync();
  Note(closed);
  RemoveOldest();
}

Status RecordingSeries::Close() {
  if (auto written = writer_->Flush(); !written) {
    Note(written);
    return written;
  }
  trouble_.reset();
  WritePending();
  WriteMissing(std::numeric_limits<std::uint64_t>::max());
  auto closed = writer_->Close();
  if (closed) closed = writer_->Sync();
  Note(closed);
  return closed;
}

void RecordingSeries::RemoveOldest() const {
  auto files = FilesOf(options_.file);
  std::uint64_t total = 0;
  for (const SeriesFile& file : files) total += file.bytes;
  const auto now = std::filesystem::file_time_type::clock::now();
  for (const SeriesFile& file : files) {
    if (file.number == file_number_) continue;
    const auto age =
        std::chrono::duration_cast<std::chrono::nanoseconds>(now - file.written);
    const bool too_many = options_.keep_bytes > 0 && total > options_.keep_bytes;
    const bool too_old = options_.keep_ns > 0 && age.count() > 0 &&
                         static_cast<std::uint64_t>(age.count()) > options_.keep_ns;
    if (!too_many && !too_old) continue;
    std::error_code ignored;
    if (std::filesystem::remove(file.path, ignored)) total -= file.bytes;
  }
}

}  // namespace intaglio::recorder
