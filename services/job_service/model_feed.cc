#include "services/job_service/model_feed.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "services/job/models/model_file.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;
using bus::Borrow;

// How often it is checked whether a discretizer that gave credit is matched by now.
constexpr auto kWatchPeriod = 50ms;

// Between processes with identities: readers of one shop come one after the other.
constexpr auto kHandshake = 1s;

// A file that is joined from several is in memory; discretizers have bounds of their
// own.
constexpr std::uint64_t kMaxJoinedBytes = std::uint64_t{1} << 30;

Error CannotRead(const std::string& file, const std::string& why) {
  return {ErrorCode::kIo, fmt::format("model {}: {}", file, why), file};
}

}  // namespace

ModelFeed::ModelFeed(bus::Bus& bus)
    : writer_(bus, bus::kModelChunk),
      credit_(bus, bus::RolePartition(bus::kStageWorkerRole)),
      wait_(bus),
      has_identities_(!bus.options().security.empty()),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

ModelFeed::~ModelFeed() {
  thread_.request_stop();
  wait_.Wake();
}

void ModelFeed::Start(const TaskId& task, std::vector<std::string> files) {
  if (files.empty()) return;  // the discretizer waits for none
  const std::lock_guard lock(mutex_);
  Stream& stream = added_.emplace_back();
  stream.task = task;
  stream.files = std::move(files);
  stream.name = bus::PartStreamName(task.job_uid, task.attempt, bus::kModelChunk.name,
                                    task.part, task.part_attempt);
  wait_.Wake();
}

void ModelFeed::Stop(const std::string& job_uid) {
  const std::lock_guard lock(mutex_);
  added_.remove_if([&](const Stream& stream) { return stream.task.job_uid == job_uid; });
  stopped_.push_back(job_uid);
  wait_.Wake();
}

std::vector<ModelFeed::Failure> ModelFeed::TakeFailures() {
  const std::lock_guard lock(mutex_);
  return std::exchange(failures_, {});
}

void ModelFeed::Run(const std::stop_token& stop) {
  wait_.Attach(credit_.reader());
  while (!stop.stop_requested()) {
    // Without a stream there is nothing to wait for.
    (void)wait_.Wait(streams_.empty() ? 1000ms : kWatchPeriod);
    credit_.Poll();
    {
      const std::lock_guard lock(mutex_);
      for (const std::string& uid : stopped_) {
        streams_.remove_if(
            [&](const Stream& stream) { return stream.task.job_uid == uid; });
      }
      stopped_.clear();
      streams_.splice(streams_.end(), added_);
    }
    for (Stream& stream : streams_) Serve(stream);
    streams_.remove_if([](const Stream& stream) { return stream.done; });
  }
}

// Whoever records a shop reads the models, too, and gives no credit.
bool ModelFeed::EverybodyHasCome() {
  if (!has_identities_) return true;
  const auto now = std::chrono::steady_clock::now();
  const int count = writer_.matched_count();
  if (std::exchange(matched_count_, count) != count) matched_at_ = now;
  return now - matched_at_ >= kHandshake;
}

void ModelFeed::Serve(Stream& stream) {
  const bus::CreditBook::Grant grant = credit_.Find(stream.name);
  if (grant.cancelled) {
    stream.done = true;  // the discretizer's TaskStatus or its death gives the reason
    return;
  }
  if (!grant.open || !writer_.IsMatched(grant.reader) || !EverybodyHasCome()) return;
  while (!stream.done && stream.sequence_number < grant.limit) {
    const Result<bool> sent = SendChunk(stream);
    if (sent && !*sent) return;
    if (!sent) {
      stream.done = true;
      const std::lock_guard lock(mutex_);
      failures_.push_back(
          {stream.task.job_uid, stream.task.attempt, sent.error().message});
    }
  }
}

Status ModelFeed::OpenNext(Stream& stream) {
  const std::string& path = stream.files.at(stream.model);
  std::error_code error;
  // A file that was replaced by a FIFO since the submission would block all jobs.
  if (!std::filesystem::is_regular_file(path, error)) {
    return tl::unexpected(
        CannotRead(path, "is no longer a file; check whether it was moved"));
  }
  stream.offset = 0;
  if (HasOtherFiles(path)) {
    auto whole = ReadModelFile(path, kMaxJoinedBytes);
    if (!whole) return tl::unexpected(CannotRead(path, whole.error().message));
    stream.file_size = whole->size();
    stream.file = std::make_unique<std::istringstream>(*std::move(whole));
    return {};
  }
  stream.file_size = std::filesystem::file_size(path, error);
  stream.file = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!error && *stream.file) return {};
  return tl::unexpected(CannotRead(path, "cannot be opened; check whether it was moved"));
}

Result<bool> ModelFeed::SendChunk(Stream& stream) {
  if (stream.file == nullptr) {
    if (auto opened = OpenNext(stream); !opened) return tl::unexpected(opened.error());
  }
  chunk_.resize(std::min<std::uint64_t>(kChunkBytes, stream.file_size - stream.offset));
  stream.file->seekg(static_cast<std::streamoff>(stream.offset));
  stream.file->read(reinterpret_cast<char*>(chunk_.data()),
                    static_cast<std::streamsize>(chunk_.size()));
  if (!*stream.file) {
    return tl::unexpected(
        CannotRead(stream.files[stream.model],
                   "cannot be read to its end; check whether it was changed"));
  }
  const bool ends_file = stream.offset + chunk_.size() == stream.file_size;
  intaglio_ModelChunk sample{};
  sample.job_uid = Borrow(stream.task.job_uid);
  sample.attempt = stream.task.attempt;
  sample.part = stream.task.part;
  sample.part_attempt = stream.task.part_attempt;
  sample.sequence_number = stream.sequence_number;
  sample.model = stream.model;
  sample.offset = stream.offset;
  sample.file_size = stream.file_size;
  sample.last = ends_file && stream.model + 1 == stream.files.size();
  Borrow(sample.bytes, chunk_);
  if (!writer_.Write(sample)) return false;
  ++stream.sequence_number;
  stream.offset += chunk_.size();
  if (ends_file) {
    stream.file.reset();
    ++stream.model;
    stream.done = stream.model == stream.files.size();
  }
  return true;
}

}  // namespace intaglio::job_service
