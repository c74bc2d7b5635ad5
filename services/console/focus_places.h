#pragma once

// Where in the glass the focus of each machine is: the axes that its motion bridge
// reports, by the frame of the job that it engraves. The job is read from its folder
// once, in the thread that reads files.

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "engrave/machine/axes_from_glass.h"
#include "proto/console.pb.h"
#include "services/client/job_view.h"
#include "services/console/cloud_reader.h"

namespace intaglio::console {

class FocusPlaces {
 public:
  /// `files` reads the jobs; it may live longer.
  explicit FocusPlaces(CloudReader& files) : files_(files) {}

  /// From one thread: the job and the focus of each stage of `state`. A job that is met
  /// for the first time has its focus at a later look.
  void Add(const std::map<std::string, client::JobView>& jobs, ConsoleState& state);

 private:
  using Axes = std::optional<machine::AxesFromGlass>;
  /// By uid of a job; a null pointer while its file is read.
  struct Known {
    std::mutex mutex;
    std::map<std::string, std::shared_ptr<const Axes>> axes;
  };
  std::shared_ptr<const Axes> AxesOf(const std::string& uid,
                                     const std::filesystem::path& folder);

  CloudReader& files_;
  std::shared_ptr<Known> known_ = std::make_shared<Known>();  // also of what is read
};

}  // namespace intaglio::console
