#include "services/replayer/credit_gate.h"

#include "services/platform/bus/cdr_sample.h"
#include "services/platform/bus/samples.h"

namespace intaglio::replayer {
namespace {

template <typename Batch>
std::optional<BatchPlace> ReadPlace(const bus::Topic<Batch>& topic,
                                    recording::ByteView cdr) {
  const auto batch = bus::CdrSample<Batch>::Read(topic, cdr);
  if (!batch) return std::nullopt;
  const Batch& b = **batch;
  std::uint32_t part = 0;  // marks come in one
  if constexpr (requires { b.part; }) part = b.part;
  return BatchPlace{bus::PartStreamName(std::string(bus::View(b.job_uid)), b.attempt,
                                        topic.name, part, b.part_attempt),
                    b.sequence_number};
}

}  // namespace

std::optional<BatchPlace> PlaceOf(const std::string& topic, recording::ByteView cdr) {
  if (topic == bus::kModelChunk.name) return ReadPlace(bus::kModelChunk, cdr);
  if (topic == bus::kPointBatch.name) return ReadPlace(bus::kPointBatch, cdr);
  if (topic == bus::kPathBatch.name) return ReadPlace(bus::kPathBatch, cdr);
  if (topic == bus::kMarkBatch.name) return ReadPlace(bus::kMarkBatch, cdr);
  if (topic == bus::kOrderedMarkBatch.name) return ReadPlace(bus::kOrderedMarkBatch, cdr);
  return std::nullopt;
}

bool CreditGate::MayGo(const BatchPlace& place, const bus::CdrWriter& writer,
                       TimePoint now) {
  book_.Poll();
  const auto grant = book_.Find(place.stream);
  anybody_ = anybody_ || grant.open;
  if (grant.cancelled) return true;
  if (grant.open) {
    return place.number < grant.limit &&
           (place.number > 0 || writer.IsMatched(grant.reader));
  }
  if (nobody_ && !anybody_) return true;
  const auto [since, added] = waits_.try_emplace(place.stream, now);
  if (now - since->second < kPatience) return false;
  nobody_ = !anybody_;
  return true;
}

}  // namespace intaglio::replayer
