#pragma once

// A shop whose machine is a mill or a laser cutter on a virtual grbl, or a scan head at a
// virtual BJJCZ board, as processes. The controller runs on beside the shop, as a machine
// does.

#include <signal.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engrave/formats/journal_file.h"
#include "engrave/mark/mark.h"
#include "tests/integration/course/tool_way.h"
#include "tests/integration/run_program.h"

namespace intaglio::testing {

/// A small job takes no longer, on a computer that is busy.
inline constexpr std::chrono::seconds kJobBound{200};

class CourseShop {
 public:
  enum class Machine { kMill, kLaser, kBoard };

  explicit CourseShop(Machine machine);
  ~CourseShop();

  std::filesystem::path folder() const { return folder_; }
  void Write(const std::string& name, const std::string& text) const;
  /// `fields` of the course; returns the job's file.
  std::filesystem::path WriteJob(const std::string& name,
                                 const std::string& fields) const;

  /// Whether it opens.
  bool Open();
  /// In an orderly way.
  void Close();
  bool IsOpen() { return up_ && up_->running(); }
  std::string Type(std::vector<std::string> words) const;
  /// Motion by hand or a zero. On a computer that is too busy for 200 ms the machine lets
  /// go, or its line is lost; the person then gives the command again.
  std::string Teach(std::vector<std::string> words) const;
  /// The words of a command, with where it finds the shop.
  std::vector<std::string> With(std::vector<std::string> words) const;
  bool Submit(const std::filesystem::path& job) const;
  /// As a person does at a computer that was too busy for its line or its arm: a paused
  /// job is resumed, without a consent to anything uncertain, and one that waits is
  /// armed.
  void GoOn();
  /// The same until its end; a shop that was killed too often is opened again.
  bool AwaitDone(std::chrono::seconds bound);
  bool AwaitState(const std::string& state, std::chrono::seconds bound);
  const std::string& shown() const { return shown_; }
  std::string Log() const { return up_ ? up_->Output() : ""; }
  /// How often this computer was too busy for the line or for permitting the beam: each
  /// time the contour in hand was ended.
  std::size_t Lapses() const;

  /// What the virtual board has written of itself.
  std::filesystem::path board_record() const { return folder_ / "record.txt"; }
  /// To its processes; how many there were.
  int Signal(const std::string& service, int signal) const;
  int Kill(const std::string& service) const { return Signal(service, SIGKILL); }
  /// A line at the controller's panel (virtual_grbl_main.cc, virtual_bjjcz_main.cc).
  void AtPanel(const std::string& command) const;

  std::vector<ToolStep> Way() const { return ReadToolWay(folder_ / "way.txt"); }
  /// The marks of job 1, in their order.
  mark::MarkSet Marks() const;
  /// The last of each, by the journal of job 1.
  std::vector<formats::PointOutcome> Outcomes(std::size_t count) const;

 private:
  std::filesystem::path JobFolder() const;

  std::filesystem::path folder_;
  std::string tag_, shown_;
  int opened_ = 0;
  std::unique_ptr<Running> controller_, up_;
};

}  // namespace intaglio::testing
