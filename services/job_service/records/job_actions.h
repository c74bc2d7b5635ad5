#pragma once

#include <string>

#include "services/job_service/records/cell_records.h"
#include "services/job_service/records/job_record.h"
#include "services/job_service/records/job_views.h"
#include "services/job_service/records/left_out.h"

namespace intaglio::job_service {

/// Carries out the decisions of the queue.
class JobActions {
 public:
  virtual ~JobActions() = default;
  /// To be kept before anything that follows from it, and published.
  virtual void Changed(const JobRecord& job) = 0;
  /// To be published; nothing is lost when it is forgotten.
  virtual void Progressed(const JobRecord& job) = 0;
  /// To be sent to the worker. A discretizer that has not received the job's models yet
  /// asks for them with this task.
  virtual void Give(const TaskOrder& order, const JobRecord& job) = 0;
  /// No discretizer needs the job's models any more.
  virtual void StopFeed(const std::string& job_uid) = 0;
  /// An ended job leaves the queue: its status is withdrawn from the bus.
  virtual void Forgotten(const JobRecord& job) = 0;
  /// So does a worker that was lost long ago: its task is withdrawn.
  virtual void WorkerForgotten(const std::string& instance) = 0;
  /// What is known of a machine's block is to be kept before anything that follows.
  virtual void PieceChanged(const PieceRecord& piece) = 0;
  virtual void BlockLoaded(const LoadedBlock& block) = 0;
  /// A worker is left out, for another reason or not any more: to be kept.
  virtual void LeftOutChanged(const LeftOut& worker) = 0;
};

}  // namespace intaglio::job_service
