#pragma once

// The services of a shop, each started by itself, so that something can be done to one of
// them: on a host of its own, with an environment of its own, stopped, limited.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/formats/glass_record.h"
#include "tests/integration/cable.h"
#include "tests/integration/run_program.h"

namespace intaglio::testing {

inline constexpr const char* kJobService = "intaglio-job-service";
inline constexpr const char* kDiscretizer = "intaglio-discretizer";
inline constexpr const char* kSorter = "intaglio-sorter";
inline constexpr const char* kSynchronizer = "intaglio-synchronizer";
inline constexpr const char* kBridge = "intaglio-motion-bridge";

class ShopFloor {
 public:
  struct Options {
    std::vector<std::string> bus;    ///< --domain and so on, for every program
    std::filesystem::path results;   ///< empty: below the folder
    std::filesystem::path database;  ///< empty: in the folder
    double machine_speed = 1;
    bool lines_over_tcp = false;  ///< on free ports of this computer
    bool one_line = false;  ///< of a controller that moves the stage and has the laser
    const TestHost* office = nullptr;  ///< of operator, job service and workers
    const TestHost* cell = nullptr;    ///< of synchronizer, bridge and machine
  };
  ShopFloor(std::filesystem::path folder, Options options);
  ~ShopFloor();

  void StartAll();
  void StartMachine();
  void StartServices();
  /// What a host has to open for the machine's "laser" or "motion" line.
  std::string DeviceOf(const std::string& line) const;
  /// Services that are started later open this device for that line instead.
  void Lead(const std::string& line, const std::string& device) { led_[line] = device; }
  /// Again, when it has run before. `environment`: of this process alone.
  void Start(const std::string& service,
             const std::map<std::string, std::string>& environment = {});
  Running& at(const std::string& service) { return *running_.at(service); }
  /// True when all health is good, as `list` sees it.
  bool Opens();

  /// A command of `intaglio`, to its end.
  Ended Type(const std::vector<std::string>& words);
  /// `words` and the options that locate the shop.
  std::vector<std::string> With(std::vector<std::string> words) const;
  /// Submits and arms the small job, or another one of the sample's model with these
  /// options, and watches it from then on; its number, or nothing.
  std::optional<std::string> Engrave(const std::vector<std::string>& options = {});

  /// Newest value in the watched job's events, e.g. of "state" or "message".
  std::string Newest(const std::string& field) const;
  bool Reaches(const std::string& state, std::chrono::milliseconds bound) const;
  std::string Events() const;

  /// A number of the machine's panel, e.g. "tick"; negative when it does not answer.
  std::int64_t Panel(const std::string& field) const;
  bool AwaitCracks(std::int64_t count, std::chrono::milliseconds bound) const;
  /// What is in the glass now.
  std::vector<formats::GlassCrack> Cracks() const;
  /// The newest lines of all logs, for a failure's message.
  std::string Logs() const;
  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path results() const { return options_.results; }

 private:
  std::vector<std::string> ArgumentsOf(const std::string& service) const;
  std::string PlugOf(const std::string& line) const;
  std::string MachineFile() const;
  std::string OpenedFor(const std::string& line) const;
  const TestHost* HostOf(const std::string& service) const;

  std::filesystem::path folder_;
  std::filesystem::path socket_folder_;  // short enough for a socket; empty: none
  Options options_;
  std::map<std::string, std::unique_ptr<Running>> running_;
  std::unique_ptr<Running> watch_;
  std::map<std::string, int> starts_;
  std::map<std::string, std::string> led_;
  int typed_ = 0;
};

/// The small job's points as a lockstep run on this computer makes them, glass frame, mm;
/// made once for the program. Empty when that run is not good.
const PointList& UndisturbedPoints();

/// What is wrong with the glass: a point that is missing, doubled or strays from the
/// undisturbed one by more than 30 um; empty when nothing is.
std::string DifferenceOf(const std::vector<formats::GlassCrack>& cracks);

/// The long forms of tests were asked for, by INTAGLIO_LONG=1.
bool LongTests();

}  // namespace intaglio::testing
