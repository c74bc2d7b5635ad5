#pragma once

// Receives all topics of both domains and writes a series of files. Three threads: the
// owner's finds new topics (Turn), one receives and only hands over, one writes. The
// queue between the two (write_queue.h) is where a slow disk shows; no process on the bus
// waits for it.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "engrave/core/result.h"
#include "services/platform/bus/bus.h"
#include "services/platform/bus/topic_filter.h"
#include "services/platform/recording/bulk.h"
#include "services/recorder/recording_series.h"
#include "services/recorder/write_queue.h"

namespace intaglio::recorder {

struct RecorderOptions {
  SeriesOptions series;
  bus::TopicFilter filter;
  recording::Bulk bulk = recording::Bulk::kAll;  ///< of what the filter accepts
  QueueLimits queue;
  bool scene = false;  ///< for standard viewers (services/scene), besides the messages
};

class Recorder {
 public:
  /// Opens the first file and begins to receive.
  static Result<std::unique_ptr<Recorder>> Start(bus::Bus& bus,
                                                 const RecorderOptions& options);
  ~Recorder();

  /// Waits for new topics, and reads from them from then on. Often, from one thread.
  void Turn(std::chrono::milliseconds timeout);
  /// Into every file from now on. From the thread of Turn.
  void Attach(recording::Attachment attachment);
  /// Receives what is still under way, writes everything and completes the file.
  Status Stop();

  struct State {
    std::string file;
    std::uint64_t message_count = 0;
    std::uint64_t missing_count = 0;
    std::optional<Error> trouble;  ///< the disk's present error
  };
  State state() const;

 private:
  struct Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace intaglio::recorder
