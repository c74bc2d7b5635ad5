#pragma once

// The part of a recording that is played, and the names under which it is played.
//
// A recording holds messages that machines obey. Played again, they would be obeyed
// again: by services that are there, and by those that start while they are retained. So
//
// - commands (JobSubmission, JobCommand, the stage tasks, MotionSegmentBatch,
//   Permission, EmergencyStop) are never played unless asked for;
// - what services believe of others (health, tasks' and machines' states, credit) is not
//   played where services live, unless commands are asked for;
// - the rest is for display, and always played.
//
// A name counts as it is played: a renamed topic is obeyed by no machine.

#include <cstdint>
#include <map>
#include <string>

#include "services/platform/bus/topic_filter.h"
#include "services/platform/recording/conventions.h"
#include "services/platform/recording/mcap_reader.h"

namespace intaglio::replayer {

enum class Weight { kShown, kBelieved, kCommand };
Weight WeightOf(const std::string& topic);

struct SelectionOptions {
  bus::NameFilter topics = {};                      ///< names in the recording
  std::map<std::string, std::string> renames = {};  ///< from the name in the recording
  bool with_commands = false;
  bool services_live = false;    ///< on the bus where it is played
  bool credit_is_given = false;  ///< by consumers there: recorded credit would mislead
};

struct PlayedChannel {
  recording::Stream stream;
  std::string name;  ///< of the topic that is written
};

struct Selection {
  std::map<std::uint16_t, PlayedChannel> channels;  ///< by id in the recording
  std::map<std::string, std::string> left_out;      ///< why, by topic in the recording
  bool believed = false;  ///< something is played that services believe
};

/// kNotFound for a rename of a topic that is not there; kInvalidValue when two types
/// would be played by one name.
Result<Selection> Select(const recording::RecordingContents& contents,
                         const SelectionOptions& options);

}  // namespace intaglio::replayer
