#pragma once

// The scene of what is recorded (services/scene), in the same files as the messages. A
// file that follows another one begins with the jobs as they are by then. From one
// thread.

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "services/platform/recording/idl_types.h"
#include "services/recorder/recording_series.h"
#include "services/scene/scene_maker.h"

namespace intaglio::recorder {

class LiveScene {
 public:
  struct Source {
    const std::string& topic;
    const std::string& type;
    const std::string& idl;
    const std::string& cell;
  };
  LiveScene();

  /// A frozen job; others are ignored.
  void Add(const recording::Attachment& attachment);
  /// A message, after it was written. What cannot be decoded is not drawn.
  void Add(const Source& source, recording::ByteView payload, std::uint64_t time_ns,
           RecordingSeries& series);
  /// After the last message.
  void Finish(RecordingSeries& series);

 private:
  std::unique_ptr<scene::SceneMaker> maker_;
  RecordingSeries* series_ = nullptr;                        // where the scene is written
  std::uint32_t file_number_ = 0;                            // in which it has begun
  std::map<std::string, RecordingSeries::Derived> derived_;  // by topic of the scene
  std::map<std::string, Result<recording::IdlTypes>> types_;  // by their name
};

}  // namespace intaglio::recorder
