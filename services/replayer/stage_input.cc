#include "services/replayer/stage_input.h"

#include <utility>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::replayer {
namespace {

enum class Turn { kSend, kWait, kDrop };

Turn TurnOf(const bus::CreditBook& credit, const std::string& stream,
            std::uint64_t number, const auto& writer) {
  const auto grant = credit.Find(stream);
  if (grant.cancelled) return Turn::kDrop;
  const bool may = grant.open && number < grant.limit &&
                   (number > 0 || writer.IsMatched(grant.reader));
  return may ? Turn::kSend : Turn::kWait;
}

/// False: it has to be tried again.
Result<bool> Sent(const Status& written) {
  if (written) return true;
  if (written.error().code == ErrorCode::kTimedOut) return false;
  return tl::unexpected(written.error());
}

}  // namespace

template <>
const bus::Topic<intaglio_PointBatch>& PointInput::topic() {
  return bus::kPointBatch;
}
template <>
const bus::Topic<intaglio_PathBatch>& PathInput::topic() {
  return bus::kPathBatch;
}

template <typename Batch>
CloudInput<Batch>::CloudInput(bus::Writer<Batch>& writer,
                              const recording::McapReader& reader,
                              const RecordedTask& task, std::string job_uid)
    : writer_(writer),
      values_(reader, topic().name),
      task_(task.id),
      job_uid_(std::move(job_uid)) {}

template <typename Batch>
Status CloudInput<Batch>::FindNext() {
  while (!next_ && !ended_) {
    auto value = INTAGLIO_TRY(values_.Next());
    ended_ = !value;
    if (ended_) break;
    auto batch = ReadBatch(*value);
    if (batch && batch->id.job_uid == task_.job_uid && batch->id.attempt == task_.attempt)
      next_ = std::move(batch);
  }
  return {};
}

template <typename Batch>
Result<bool> CloudInput<Batch>::Advance(const bus::CreditBook& credit) {
  for (;;) {
    INTAGLIO_TRY(FindNext());
    if (!next_) return true;
    const CloudBatch& batch = *next_;
    const auto turn = TurnOf(credit,
                             bus::PartStreamName(job_uid_, batch.id.attempt, topic().name,
                                                 batch.id.part, batch.id.part_attempt),
                             batch.sequence_number, writer_);
    if (turn == Turn::kWait) return false;
    if (turn == Turn::kSend) {
      Batch sample{};
      sample.job_uid = bus::Borrow(job_uid_);
      sample.attempt = batch.id.attempt;
      sample.part = batch.id.part;
      sample.part_count = batch.part_count;
      sample.part_attempt = batch.id.part_attempt;
      sample.sequence_number = batch.sequence_number;
      sample.first_index = batch.first_index;
      sample.total_count = batch.total_count;
      sample.last = batch.last;
      bus::Borrow(sample.x_mm, batch.x_mm);
      bus::Borrow(sample.y_mm, batch.y_mm);
      bus::Borrow(sample.z_mm, batch.z_mm);
      bus::Borrow(sample.source, batch.source);
      const auto sent = Sent(writer_.Write(sample));
      if (!sent || !*sent) return sent;
    }
    next_.reset();
  }
}

template class CloudInput<intaglio_PointBatch>;
template class CloudInput<intaglio_PathBatch>;

ModelInput::ModelInput(bus::Writer<intaglio_ModelChunk>& writer,
                       const recording::McapReader& reader, const StreamId& recorded,
                       const StreamId& played)
    : writer_(writer),
      values_(reader, bus::kModelChunk.name),
      recorded_(recorded),
      played_(played) {}

Status ModelInput::FindNext() {
  while (!next_ && !ended_) {
    auto value = INTAGLIO_TRY(values_.Next());
    ended_ = !value;
    if (ended_) break;
    auto piece = ReadPiece(*value);
    if (piece && piece->id == recorded_) next_ = std::move(piece);
  }
  return {};
}

Result<bool> ModelInput::Advance(const bus::CreditBook& credit) {
  const std::string stream =
      bus::PartStreamName(played_.job_uid, played_.attempt, bus::kModelChunk.name,
                          played_.part, played_.part_attempt);
  for (;;) {
    // Models are large: nothing is read before it is requested.
    if (!credit.Find(stream).open) return false;
    INTAGLIO_TRY(FindNext());
    if (!next_) return true;
    const ModelPiece& piece = *next_;
    const auto turn = TurnOf(credit, stream, piece.sequence_number, writer_);
    if (turn == Turn::kDrop) return true;
    if (turn == Turn::kWait) return false;
    intaglio_ModelChunk sample{};
    sample.job_uid = bus::Borrow(played_.job_uid);
    sample.attempt = played_.attempt;
    sample.part = played_.part;
    sample.part_attempt = played_.part_attempt;
    sample.sequence_number = piece.sequence_number;
    sample.model = piece.model;
    sample.offset = piece.offset;
    sample.file_size = piece.file_size;
    sample.last = piece.last;
    bus::Borrow(sample.bytes, piece.bytes);
    const auto sent = Sent(writer_.Write(sample));
    if (!sent || !*sent) return sent;
    next_.reset();
  }
}

}  // namespace intaglio::replayer
