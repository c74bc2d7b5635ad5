#pragma once

// A shop that engraves points in glass at a controller which moves the stage and has the
// laser: the virtual controller and the product's processes, each a process of its own,
// and one job. The record that the controller writes is the judge.

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/formats/journal_file.h"
#include "tests/integration/run_program.h"

namespace intaglio::testing {

class PointShop {
 public:
  struct Options {
    std::string controller;                ///< "grbl", of the program virtual-grbl
    std::string profile;                   ///< "grbl", of deploy/machines/grbl.textproto
    std::string more_of_motion_line = {};  ///< fields behind the protocol and the device
    std::string line = {};  ///< of the controller; empty: a pseudo-terminal
    std::vector<std::string> controller_options = {};
    /// A program of the product in place of virtual-CONTROLLER, with these options alone.
    /// In them and in other_lines "FOLDER" is folder().
    std::string program = {};
    /// More options of `intaglio up`.
    std::vector<std::string> up_options = {};
    /// Files that the program reads, written into folder() first: names and texts.
    std::vector<std::pair<std::string, std::string>> files = {};
    /// More options of `intaglio machine new`, which makes the profile then; other_lines
    /// are not used.
    std::vector<std::string> new_options = {};
    /// The profile's line that begins with the first is the second.
    std::vector<std::pair<std::string, std::string>> other_lines = {};
    /// The controller is a BJJCZ board on the bus of fake_libusb.cc, which is the
    /// programs' library then: folder()/usb.
    bool on_usb = false;
    bool has_panel = false;  ///< AskPanel() of the folder works it
    std::string job;         ///< models, discretization and laser of a job file
  };
  explicit PointShop(const Options& options);
  ~PointShop();

  /// Whether it opens.
  bool Open();
  /// Its processes were killed too often for it to go on by itself.
  bool IsOpen() const { return shop_ && shop_->running(); }
  /// A command of `intaglio`, to its end; what it prints.
  std::string Type(std::vector<std::string> words) const;
  /// The same, which runs until it ends, or its object goes.
  std::unique_ptr<Running> Start(std::vector<std::string> words) const;
  /// Submits and arms the job. Whether it is accepted.
  bool Submit() const;
  /// `resuming`: a paused job is resumed, a closed shop opened again.
  bool AwaitDone(std::chrono::seconds bound, bool resuming);
  /// By SIGKILL.
  void KillController();
  /// Once more with the same options; it replaces record().
  void RestartController() { StartController(options_); }
  /// With SIGKILL; how many there were.
  int Kill(const std::string& service) const;

  /// The job's points in their order, and the outcome that the journal has last of each.
  /// Empty when there is none.
  struct Points {
    PointList at_mm;
    std::vector<formats::PointOutcome> last;
    std::size_t UncertainCount() const;
  };
  Points PointsOfJob() const;

  std::filesystem::path record() const { return folder_ / "record.txt"; }
  std::filesystem::path job() const { return folder_ / "job.textproto"; }
  std::filesystem::path profile() const { return folder_ / "machine.textproto"; }
  const std::filesystem::path& folder() const { return folder_; }
  const std::string& shown() const { return shown_; }
  std::string Log() const { return shop_ ? shop_->Output() : ""; }

 private:
  /// The device that a host opens.
  std::string StartController(const Options& options);
  std::string InFolder(std::string text) const;
  void WriteProfile(const Options& options, const std::string& device) const;
  void MakeProfile(const Options& options, const std::string& device) const;

  Options options_;
  std::filesystem::path folder_;
  std::string tag_, shown_;
  // Its path is short: that of a socket has 107 bytes.
  std::string socket_;
  int opened_ = 0;
  std::unique_ptr<Running> controller_, shop_;
};

/// models { ... } of the supplied knot, so high, and its spacing.
std::string KnotOf(double height_mm, double spacing_mm);

}  // namespace intaglio::testing
