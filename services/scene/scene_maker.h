#pragma once

// Makes a scene for standard viewers (Foxglove, Lichtblick, Rerun) from the messages of a
// recording, one after the other. Of each job whose number is N:
//
//   topic         message                  when
//   job-N/frame   foxglove.FrameTransform  once: its block, in the frame "world"
//   job-N/block   foxglove.SceneUpdate     once: block and stage, if the job is known
//   job-N/plan    foxglove.PointCloud      the points to come, when the path is whole and
//                                          with each of the next
//   job-N/made    foxglove.PointCloud      all that became of its pulses so far, when
//                                          they have grown by a twentieth of the path
//   job-N/new     foxglove.PointCloud      the pulses of each report
//   job-N/beam    foxglove.SceneUpdate     20 a second: the focus where the axes are
//   alarms        foxglove.Log             with each alarm
//
// The frame of a job is that of its glass: the origin is the lower corner of the block, z
// is up, and a unit is a millimetre. Jobs lie side by side along x. The points of a cloud
// have x, y, z, a colour, their place in the order and, of pulses, the tick: the
// plan is grey, made blue, missed orange, uncertain red. Marks of scan heads are not
// drawn; of more than 16 jobs the oldest are forgotten.

#include <google/protobuf/message.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "engrave/core/result.h"
#include "proto/task.pb.h"
#include "services/platform/recording/cdr_value.h"
#include "services/platform/recording/mcap_records.h"

namespace intaglio::scene {

/// Receives each message of the scene. `time_ns`: of the message that it follows from.
using SceneSink = std::function<Status(const std::string& topic,
                                       const google::protobuf::Message& message,
                                       std::uint64_t time_ns)>;

/// The job in an attachment of a recording; none in others, and in one that is damaged.
std::optional<FrozenJob> JobOf(const recording::Attachment& attachment);

class JobScene;

class SceneMaker {
 public:
  /// Whether the messages of this topic are drawn.
  static bool Draws(const std::string& topic);

  explicit SceneMaker(SceneSink sink);
  ~SceneMaker();
  SceneMaker(const SceneMaker&) = delete;
  SceneMaker& operator=(const SceneMaker&) = delete;

  /// A job, before its messages; without it they are drawn without block and beam.
  void AddJob(const FrozenJob& job);
  /// `cell`: that the message is of; empty: none. Errors are those of the sink.
  Status Add(const std::string& topic, const std::string& cell,
             const recording::Value& message, std::uint64_t time_ns);
  /// Draws what is behind the last growth; after the last message. Errors are those of
  /// the sink.
  Status Finish();
  /// All jobs are drawn again with their next message, whole: another file begins.
  void BeginAnew();

  std::uint64_t drawn_count() const;  ///< points of plans and of pulses

 private:
  JobScene& SceneOf(const std::string& job_uid);
  void ForgetOldest();
  Status AddAlarm(const recording::Value& alarm, std::uint64_t time_ns);

  SceneSink sink_;
  std::map<std::string, FrozenJob> jobs_;                    // by uid
  std::map<std::string, std::unique_ptr<JobScene>> scenes_;  // by uid
  std::deque<std::string> by_age_;                           // uids in scenes_
  std::map<std::string, JobScene*> at_cell_;                 // whose pulses came last
  std::uint64_t drawn_of_forgotten_ = 0;
  double next_x_mm_ = 0;  // of the next job's block
};

}  // namespace intaglio::scene
