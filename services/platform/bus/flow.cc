#include "services/platform/bus/flow.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "services/platform/bus/samples.h"

namespace intaglio::bus {
namespace {
constexpr std::size_t kRememberedEnds = 256;
constexpr std::chrono::seconds kRepeatPeriod{1};
}  // namespace

std::string StreamName(const std::string& job_uid, std::uint32_t attempt,
                       const char* topic) {
  return fmt::format("{}/{}/{}", job_uid, attempt, topic);
}

std::string PartStreamName(const std::string& job_uid, std::uint32_t attempt,
                           const char* topic, std::uint32_t part,
                           std::uint32_t part_attempt) {
  return fmt::format("{}/{}.{}", StreamName(job_uid, attempt, topic), part, part_attempt);
}

CreditGrantor::CreditGrantor(Bus& bus, std::string instance, const std::string& partition)
    : instance_(std::move(instance)), writer_(bus, kCredit, partition) {}

Status CreditGrantor::Publish(const std::string& name, const Stream& stream) {
  intaglio_Credit sample{};
  sample.stream = Borrow(name);
  sample.consumer = Borrow(instance_);
  std::memcpy(sample.reader_guid, stream.reader.data(), stream.reader.size());
  sample.consumed = stream.consumed;
  sample.window = stream.window;
  sample.cancelled = stream.cancelled;
  return writer_.Write(sample);
}

Status CreditGrantor::Open(const std::string& stream, const Guid& reader,
                           std::uint32_t window) {
  repeated_at_ = std::chrono::steady_clock::now();
  Stream& opened = streams_[stream] = {reader, window};
  return Publish(stream, opened);
}

Status CreditGrantor::Consumed(const std::string& stream, std::uint64_t consumed,
                               bool now) {
  const auto found = streams_.find(stream);
  if (found == streams_.end()) return {};
  Stream& open = found->second;
  open.consumed = std::max(open.consumed, consumed);
  const std::uint64_t step = std::max<std::uint64_t>(1, open.window / 4);
  if (open.consumed == open.published ||
      (!now && open.consumed < open.published + step)) {
    return {};
  }
  auto written = Publish(stream, open);
  if (written) open.published = open.consumed;
  return written;
}

Status CreditGrantor::CheckGranted(const std::string& stream,
                                   std::uint64_t number) const {
  const auto found = streams_.find(stream);
  const std::uint64_t end =
      found == streams_.end() ? 0 : found->second.published + found->second.window;
  if (number < end) return {};
  return Fail(ErrorCode::kFault,
              fmt::format("batch {} of {} exceeds the granted credit, batches below {}: "
                          "the sender has another version or is faulty; restart it and "
                          "submit the job again",
                          number, stream, end));
}

Status CreditGrantor::Cancel(const std::string& stream) {
  const auto found = streams_.find(stream);
  if (found == streams_.end()) return {};
  found->second.cancelled = true;
  return Publish(stream, found->second);
}

void CreditGrantor::Repeat(std::chrono::steady_clock::time_point now) {
  if (now - repeated_at_ < kRepeatPeriod) return;
  repeated_at_ = now;
  for (auto& [name, stream] : streams_) {
    if (Publish(name, stream)) stream.published = stream.consumed;
  }
}

Status CreditGrantor::Close(const std::string& stream) {
  if (streams_.erase(stream) == 0) return {};
  intaglio_Credit sample{};
  sample.stream = Borrow(stream);
  sample.consumer = Borrow(instance_);
  return writer_.Dispose(sample);
}

CreditBook::CreditBook(Bus& bus, const std::string& partition)
    : reader_(bus, kCredit, partition) {}

void CreditBook::Poll() {
  reader_.TakeAll([this](const intaglio_Credit& sample, const SampleOrigin& origin) {
    const std::string stream(View(sample.stream));
    if (!origin.alive) {
      grants_[stream].cancelled = true;
      ended_.push_back(stream);
      return;
    }
    Grant& grant = grants_[stream];
    grant.open = true;
    grant.cancelled = sample.cancelled;
    std::memcpy(grant.reader.data(), sample.reader_guid, grant.reader.size());
    grant.consumed = sample.consumed;
    grant.limit = sample.consumed + sample.window;
  });
  while (ended_.size() > kRememberedEnds) {
    const auto found = grants_.find(ended_.front());
    if (found != grants_.end() && found->second.cancelled) grants_.erase(found);
    ended_.pop_front();
  }
}

CreditBook::Grant CreditBook::Find(const std::string& stream) const {
  const auto found = grants_.find(stream);
  return found == grants_.end() ? Grant{} : found->second;
}

}  // namespace intaglio::bus
