#pragma once

// Sends the model files of jobs to their discretizers, in chunks, under credit, from a
// thread of its own: a bulk write may block for a second, and permissions may not wait.
// A file that consists of several (services/job/models/model_file.h) goes out as one.
// Every task of a discretizer may ask for them, by its credit; one that has them from the
// task before does not.

#include <chrono>
#include <cstdint>
#include <istream>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "engrave/core/result.h"
#include "services/job_service/records/task_id.h"
#include "services/platform/bus/bus.h"
#include "services/platform/bus/flow.h"

namespace intaglio::job_service {

inline constexpr std::size_t kChunkBytes = 64 * 1024;

class ModelFeed {
 public:
  explicit ModelFeed(bus::Bus& bus);
  ~ModelFeed();

  /// From any thread. The files go out in this order as soon as the discretizer grants
  /// credit for the stream of this task.
  void Start(const TaskId& task, std::vector<std::string> files);
  /// For all tasks of the job.
  void Stop(const std::string& job_uid);

  struct Failure {
    std::string job_uid;
    std::uint32_t attempt = 0;
    std::string message;
  };
  /// What could not be read since the last call.
  std::vector<Failure> TakeFailures();

 private:
  struct Stream {
    TaskId task;
    std::vector<std::string> files;
    std::string name;
    std::uint64_t sequence_number = 0;
    std::uint32_t model = 0;
    std::uint64_t offset = 0;
    std::uint64_t file_size = 0;
    std::unique_ptr<std::istream> file;
    bool stopped = false;
    bool done = false;
  };

  void Run(const std::stop_token& stop);
  /// No reader has come for as long as a handshake takes; always without identities.
  bool EverybodyHasCome();
  void Serve(Stream& stream);
  Status OpenNext(Stream& stream);
  /// False: not now.
  Result<bool> SendChunk(Stream& stream);

  bus::Writer<intaglio_ModelChunk> writer_;
  bus::CreditBook credit_;
  bus::WaitSet wait_;
  bool has_identities_;
  int matched_count_ = 0;
  std::chrono::steady_clock::time_point matched_at_;

  std::mutex mutex_;  // over the three below
  std::list<Stream> added_;
  std::vector<std::string> stopped_;
  std::vector<Failure> failures_;

  std::list<Stream> streams_;  // of the thread
  std::vector<std::uint8_t> chunk_;
  std::jthread thread_;
};

}  // namespace intaglio::job_service
