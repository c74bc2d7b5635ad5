#include "services/discretizer/model_intake.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::discretizer {
namespace {
// 4 MB in flight when a chunk is 64 KiB.
constexpr std::uint32_t kWindowChunks = 64;
}  // namespace

ModelIntake::ModelIntake(bus::Bus& bus, const std::string& instance,
                         const ReadLimits& limits)
    : reader_(bus, bus::kModelChunk), credit_(bus, instance), limits_(limits) {}

Status ModelIntake::Open(const std::string& job_uid, std::uint32_t attempt,
                         host::TaskPart part, std::size_t model_count) {
  Close();
  if (model_count == 0) {  // all points are in the job itself
    complete_ = true;
    return {};
  }
  job_uid_ = job_uid;
  attempt_ = attempt;
  part_ = part;
  model_count_ = model_count;
  stream_ = bus::PartStreamName(job_uid, attempt, bus::kModelChunk.name, part.index,
                                part.attempt);
  return credit_.Open(stream_, reader_.guid(), kWindowChunks);
}

void ModelIntake::Close() {
  if (!stream_.empty()) (void)credit_.Close(stream_);
  stream_.clear();
  files_.clear();
  expected_ = file_size_ = total_bytes_ = 0;
  complete_ = false;
}

Result<bool> ModelIntake::Poll() {
  Status status;
  reader_.Take([&](const intaglio_ModelChunk& chunk) {
    if (stream_.empty() || complete_ || !status) return;
    if (bus::View(chunk.job_uid) != job_uid_ || chunk.attempt != attempt_) return;
    if (chunk.part != part_.index || chunk.part_attempt != part_.attempt) return;
    status = Accept(chunk);
  });
  // What has come was sent under the credit of earlier turns.
  if (status) status = credit_.Consumed(stream_, expected_, complete_);
  if (!status) return tl::unexpected(status.error());
  return complete_;
}

Status ModelIntake::Check(const intaglio_ModelChunk& chunk) const {
  if (chunk.sequence_number != expected_) {
    return Fail(ErrorCode::kLinkLost,
                fmt::format("chunk {} of the models is missing: assign the task again",
                            expected_));
  }
  INTAGLIO_TRY(credit_.CheckGranted(stream_, chunk.sequence_number));
  const bool begins = chunk.offset == 0 && chunk.model == files_.size() &&
                      (files_.empty() || files_.back().size() == file_size_);
  const bool continues = !files_.empty() && chunk.model + 1 == files_.size() &&
                         chunk.offset == files_.back().size() &&
                         chunk.file_size == file_size_;
  const std::uint64_t end = chunk.offset + chunk.bytes._length;
  const bool ends_right =
      !chunk.last || (end == chunk.file_size && chunk.model + 1 == model_count_);
  if (!(begins || continues) || chunk.model >= model_count_ || end > chunk.file_size ||
      !ends_right) {
    return Fail(ErrorCode::kFault,
                fmt::format("chunk {} of the models does not match the previous ones",
                            expected_));
  }
  if (begins && (chunk.file_size > limits_.max_file_bytes ||
                 total_bytes_ + chunk.file_size > limits_.max_file_bytes)) {
    Error error{ErrorCode::kTooLarge,
                fmt::format("the models of the job are larger than {} MiB together: "
                            "simplify them, or raise the limit",
                            limits_.max_file_bytes >> 20),
                std::to_string(total_bytes_ + chunk.file_size)};
    return tl::unexpected(WithRemedy(std::move(error), limits_));
  }
  return {};
}

Status ModelIntake::Accept(const intaglio_ModelChunk& chunk) {
  INTAGLIO_TRY(Check(chunk));
  if (chunk.offset == 0 && chunk.model == files_.size()) {
    files_.emplace_back();
    files_.back().reserve(chunk.file_size);
    file_size_ = chunk.file_size;
    total_bytes_ += chunk.file_size;
  }
  const auto bytes = std::as_bytes(bus::View(chunk.bytes));
  files_.back().insert(files_.back().end(), bytes.begin(), bytes.end());
  ++expected_;
  complete_ = chunk.last;
  return {};
}

}  // namespace intaglio::discretizer
