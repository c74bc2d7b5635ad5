#pragma once

// Receives the model files of one job after another from the job service, under credit.
// The stream is that of the task that asks for them, so that every discretizer has its
// own. Used from the wait set's thread alone.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/job/models/model_sources.h"
#include "services/platform/bus/flow.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::discretizer {

/// The files in the order of FilesOf (services/job/convert/model_kind.h).
class ModelIntake {
 public:
  ModelIntake(bus::Bus& bus, const std::string& instance, const ReadLimits& limits);

  /// Gives the sender its credit for these many models; forgets an earlier stream. 0: all
  /// is whole at once.
  Status Open(const std::string& job_uid, std::uint32_t attempt, host::TaskPart part,
              std::size_t model_count);
  /// Takes what has come and drops what is not of the open stream, also when none is
  /// open; true when all models are whole. kLinkLost: a chunk is missing. kFault: a chunk
  /// contradicts the ones before it or exceeds the credit. kTooLarge: all models together
  /// are above ReadLimits::max_file_bytes.
  Result<bool> Poll();
  void Close();
  /// The files in the order of the job, once.
  std::vector<FileBytes> TakeFiles() { return std::move(files_); }
  bus::Reader<intaglio_ModelChunk>& reader() { return reader_; }

 private:
  Status Accept(const intaglio_ModelChunk& chunk);
  Status Check(const intaglio_ModelChunk& chunk) const;

  bus::Reader<intaglio_ModelChunk> reader_;
  bus::CreditGrantor credit_;
  ReadLimits limits_;
  std::string job_uid_, stream_;
  std::uint32_t attempt_ = 0;
  host::TaskPart part_;
  std::size_t model_count_ = 0;
  std::uint64_t expected_ = 0;   // number of the next chunk
  std::uint64_t file_size_ = 0;  // of the last file begun
  std::uint64_t total_bytes_ = 0;
  bool complete_ = false;
  std::vector<FileBytes> files_;
};

}  // namespace intaglio::discretizer
