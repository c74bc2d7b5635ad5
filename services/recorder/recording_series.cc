#include "services/recorder/recording_series.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "engrave/core/try.h"
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
constexpr std::uint64_t kRemovePeriodNs = 60'000'000'000;

std::string UtcText(std::uint64_t ns) {
  const auto seconds = static_cast<std::time_t>(ns / 1'000'000'000);
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(seconds));
}

/// What may be carried over from file to file: nothing when none follows, and not so much
/// that a file has no room for what is new.
std::uint64_t Carried(const SeriesOptions& options, std::uint64_t limit_bytes,
                      std::uint64_t share) {
  if (options.split_bytes == 0) return options.split_ns > 0 ? limit_bytes : 0;
  return std::min(limit_bytes, options.split_bytes / share);
}
std::uint64_t RetainedLimit(const SeriesOptions& options) {
  return Carried(options, options.retained_bytes, 2);
}

recording::SampleType TypeOf(const recording::Stream& stream, const StreamTypes& types) {
  const bool value = stream.kind == recording::SampleKind::kValue;
  const auto keys = types.recipe.find("keys");
  return {value ? stream.type : stream.type + "_key", value ? types.idl : types.key_idl,
          keys == types.recipe.end() ? "" : keys->second};
}

}  // namespace

RecordingSeries::RecordingSeries(const SeriesOptions& options, std::uint64_t now_ns)
    : options_(options),
      file_began_ns_(now_ns),
      retained_(RetainedLimit(options)),
      retained_limit_bytes_(RetainedLimit(options)),
      attachments_limit_bytes_(Carried(options, options.attachments_bytes, 4)) {}

Result<RecordingSeries> RecordingSeries::Open(const SeriesOptions& options,
                                              std::uint64_t now_ns) {
  RecordingSeries series(options, now_ns);
  const auto there = FilesOf(options.file);
  series.file_number_ = there.empty() ? 0 : there.back().number;
  INTAGLIO_TRY(series.OpenNext(now_ns));
  return series;
}

Status RecordingSeries::OpenNext(std::uint64_t now_ns) {
  recording::WriterOptions writer_options = options_.writer;
  writer_options.library = "intaglio " + options_.version;
  writer_options.keep_existing = true;
  std::uint32_t number = file_number_;
  Result<recording::McapWriter> writer = Fail(ErrorCode::kRefused, "");
  // Another recorder may have taken the next name meanwhile.
  while (!writer && writer.error().code == ErrorCode::kRefused) {
    writer =
        recording::McapWriter::Create(PathOf(options_.file, ++number), writer_options);
  }
  if (!writer) return tl::unexpected(writer.error());
  file_number_ = number;
  ForgetOldAttachments();
  writer_ = std::move(*writer);
  file_began_ns_ = now_ns;
  for (Known& known : streams_) {
    known.channel.reset();
    known.repeated.reset();
  }
  repeated_ = retained_.empty();
  stream_of_channel_.clear();
  derived_count_.clear();
  types_written_.clear();
  attachments_written_ = unrecorded_written_ = 0;
  Metadata about{recording::kRecordingRecord, recording::EntriesOf(options_.bulk)};
  about.entries.merge(recording::TextMap{{"version", options_.version},
                                         {"host", options_.host},
                                         {"started_utc", UtcText(now_ns)},
                                         {"file_number", std::to_string(file_number_)}});
  Note(writer_->Write(about));
  ReportForgotten();
  WritePending();
  return {};
}

std::uint32_t RecordingSeries::AddStream(const recording::Stream& stream,
                                         const StreamTypes& types) {
  for (std::uint32_t i = 0; i < streams_.size(); ++i) {
    if (streams_[i].stream == stream) return i;
  }
  streams_.push_back({stream, types, std::nullopt, std::nullopt, 0});
  const auto number = static_cast<std::uint32_t>(streams_.size() - 1);
  if (retained_limit_bytes_ > 0 && recording::IsRetained(stream))
    (void)retained_.Learn(number, stream, TypeOf(stream, types));
  return number;
}

/// The stream's channel in this file.
std::uint16_t RecordingSeries::Define(const Known& known, bool repeated) {
  recording::Stream stream = known.stream;
  stream.repeated = repeated;
  const recording::SampleType type = TypeOf(stream, known.types);
  recording::Channel made = recording::ChannelOf(stream);
  made.schema_id =
      writer_->AddSchema(type.name, type.idl.empty() ? "" : recording::kOmgIdl, type.idl);
  const std::uint16_t channel =
      writer_->AddChannel(std::move(made), stream.bulk ? Lane::kLarge : Lane::kSmall);
  const bool reported = std::find(types_written_.begin(), types_written_.end(),
                                  stream.type) != types_written_.end();
  if (reported || known.types.recipe.empty()) return channel;
  const auto written =
      writer_->Write(Metadata{recording::kTypeRecord, known.types.recipe});
  if (written) types_written_.push_back(stream.type);
  Note(written);
  return channel;
}

// At the first message of the file, so that none in it is older: what waited in a queue
// when the file began was received before that. In order, as one of its readers would.
void RecordingSeries::Repeat(std::uint64_t log_time_ns) {
  if (repeated_) return;
  repeated_ = true;
  for (const recording::RetainedSample* sample : retained_.Samples()) {
    Known& known = streams_[sample->stream];
    if (trouble_ && known.stream.bulk) continue;
    if (!known.repeated) known.repeated = Define(known, true);
    Note(writer_->Write(recording::MessageView{*known.repeated, sample->sequence,
                                               log_time_ns, sample->publish_time_ns,
                                               sample->payload}));
  }
}

void RecordingSeries::ReportForgotten() {
  const std::uint64_t count = retained_.forgotten_count();
  if (count == 0) return;
  Note(
      writer_->Write(Metadata{recording::kForgottenRecord,
                              {{"file_number", std::to_string(file_number_)},
                               {"count", std::to_string(count)},
                               {"limit_bytes", std::to_string(retained_limit_bytes_)}}}));
}

void RecordingSeries::Write(std::uint32_t stream, std::uint64_t log_time_ns,
                            std::uint64_t publish_time_ns, recording::ByteView payload) {
  Known& known = streams_.at(stream);
  Repeat(std::min(file_began_ns_, log_time_ns));
  retained_.Receive(stream, known.sequence, log_time_ns, publish_time_ns, payload);
  if (trouble_ && known.stream.bulk) {
    CountMissing(stream, log_time_ns, "writing to the disk failed");
    return;
  }
  if (!known.channel) {
    known.channel = Define(known, false);
    stream_of_channel_[*known.channel] = stream;
  }
  ++message_count_;
  Note(writer_->Write(recording::MessageView{*known.channel, known.sequence++,
                                             log_time_ns, publish_time_ns, payload}));
  if (trouble_ && writer_->gathered_bytes(Lane::kSmall) > kMaxWaitingBytes) {
    GiveUp(Lane::kSmall, "writing to the disk failed for too long");
  }
}

void RecordingSeries::Write(const Derived& of, std::uint64_t log_time_ns,
                            recording::ByteView payload) {
  if (trouble_) return;
  recording::Channel channel;
  channel.schema_id = writer_->AddSchema(of.type, of.encoding, of.schema);
  channel.topic = of.topic;
  channel.message_encoding = of.encoding;
  const std::uint16_t id = writer_->AddChannel(std::move(channel), Lane::kLarge);
  Note(writer_->Write(recording::MessageView{id, derived_count_[of.topic]++, log_time_ns,
                                             log_time_ns, payload}));
}

// Bulk is given up at once: it would fill the memory within seconds.
void RecordingSeries::Note(const Status& written) {
  if (written) return;
  trouble_ = written.error();
  GiveUp(Lane::kLarge, "writing to the disk failed");
}

void RecordingSeries::GiveUp(Lane lane, const char* reason) {
  for (const auto& [channel, dropped] : writer_->Drop(lane)) {
    const auto known = stream_of_channel_.find(channel);
    if (known == stream_of_channel_.end()) continue;  // repeats
    const std::uint32_t stream = known->second;
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

void RecordingSeries::ReportUnrecorded(const std::string& topic,
                                       const std::string& reason) {
  unrecorded_.push_back(
      {recording::kMissingRecord, {{"topic", topic}, {"reason", reason}}});
}

void RecordingSeries::Attach(recording::Attachment attachment) {
  attachments_.push_back(std::move(attachment));
  WritePending();
}

// They were in the files before; the newest jobs matter most.
void RecordingSeries::ForgetOldAttachments() {
  std::uint64_t total = 0;
  for (const recording::Attachment& attachment : attachments_)
    total += attachment.content.size();
  while (attachments_written_ > 0 && total > attachments_limit_bytes_) {
    total -= attachments_.front().content.size();
    attachments_.pop_front();
    --attachments_written_;
  }
}

void RecordingSeries::WritePending() {
  while (!trouble_ && attachments_written_ < attachments_.size()) {
    const auto written = writer_->Write(attachments_[attachments_written_]);
    if (written) ++attachments_written_;
    Note(written);
  }
  if (attachments_limit_bytes_ == 0) ForgetOldAttachments();
  while (!trouble_ && unrecorded_written_ < unrecorded_.size()) {
    const auto written = writer_->Write(unrecorded_[unrecorded_written_]);
    if (written) ++unrecorded_written_;
    Note(written);
  }
}

// A span of missing messages is recorded when it is over, or has lasted: one record
// instead of many.
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
  // A clock that was set back begins anew.
  file_began_ns_ = std::min(file_began_ns_, now_ns);
  if (split_refused_ns_ > now_ns) split_refused_ns_ = now_ns;
  // By then nothing waits any more that was received before the file began.
  if (now_ns >= file_began_ns_ + kQuietNs) Repeat(file_began_ns_);
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
  const bool soon_again = split_refused_ns_ && now_ns < *split_refused_ns_ + kQuietNs;
  if (!trouble_ && (full || long_enough) && !soon_again) BeginNext(now_ns);
  // Also while no file follows: files grow older, and a recorder that was restarted finds
  // those of the one before.
  if (removed_ns_ && now_ns >= *removed_ns_ && now_ns < *removed_ns_ + kRemovePeriodNs)
    return;
  removed_ns_ = now_ns;
  RemoveOldest();
}

// Syncs at full speed as seldom as when few messages come: a sync takes time on a disk. A
// clock that was set back begins anew.
void RecordingSeries::SyncIfDue(std::uint64_t now_ns) {
  const bool early = now_ns >= synced_ns_ && now_ns < synced_ns_ + kSyncPeriodNs;
  if (trouble_ || early || writer_->synced_bytes() == writer_->file_bytes()) return;
  synced_ns_ = now_ns;
  Note(writer_->Sync());
}

// The old file is left only when the new one is there, and takes all until then.
void RecordingSeries::BeginNext(std::uint64_t now_ns) {
  Repeat(file_began_ns_);
  const auto flushed = writer_->Flush();
  Note(flushed);
  if (!flushed) return;
  recording::McapWriter before = std::move(*writer_);
  auto opened = OpenNext(now_ns);
  if (!opened) {
    writer_ = std::move(before);
    split_refused_ns_ = now_ns;
    no_next_file_ = opened.error();
    return;
  }
  split_refused_ns_.reset();
  no_next_file_.reset();
  auto closed = before.Close();
  if (closed) closed = before.Sync();
  Note(closed);
  RemoveOldest();
}

Status RecordingSeries::Close() {
  Repeat(file_began_ns_);
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
  if (options_.keep_bytes == 0 && options_.keep_ns == 0) return;
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
