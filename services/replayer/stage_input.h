#pragma once

// The recorded input of a stage, sent to it once more, under its credit.

#include <chrono>
#include <memory>
#include <optional>

#include "services/platform/bus/flow.h"
#include "services/replayer/recorded_samples.h"

namespace intaglio::replayer {

class StageInput {
 public:
  virtual ~StageInput() = default;
  /// Sends what may be sent; false while some is left. Never blocks.
  virtual Result<bool> Advance(const bus::CreditBook& credit) = 0;
};

/// All parts and turns of the points of a sort, or the path of an engraving, in the order
/// in which they were recorded.
template <typename Batch>
class CloudInput final : public StageInput {
 public:
  /// The input of the task, under `job_uid`.
  CloudInput(bus::Writer<Batch>& writer, const recording::McapReader& reader,
             const RecordedTask& task, std::string job_uid);
  Result<bool> Advance(const bus::CreditBook& credit) override;

 private:
  static const bus::Topic<Batch>& topic();
  Status FindNext();
  bus::Writer<Batch>& writer_;
  RecordedValues values_;
  StreamId task_;
  std::string job_uid_;
  std::optional<CloudBatch> next_;
  bool ended_ = false;
};
using PointInput = CloudInput<intaglio_PointBatch>;
using PathInput = CloudInput<intaglio_PathBatch>;

/// The models of a job, from a stream that is whole, as the task's own stream. Perhaps
/// they are never requested: a discretizer keeps them from part to part.
class ModelInput final : public StageInput {
 public:
  ModelInput(bus::Writer<intaglio_ModelChunk>& writer,
             const recording::McapReader& reader, const StreamId& recorded,
             const StreamId& played);
  Result<bool> Advance(const bus::CreditBook& credit) override;

 private:
  Status FindNext();
  bus::Writer<intaglio_ModelChunk>& writer_;
  RecordedValues values_;
  StreamId recorded_, played_;
  std::optional<ModelPiece> next_;
  bool ended_ = false;
};

}  // namespace intaglio::replayer
