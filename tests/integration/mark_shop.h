#pragma once

// A shop whose machine is the virtual scan head, with one job of marks; the judge is the
// record of its material: which mark was burnt in which run.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engrave/formats/journal_file.h"
#include "tests/integration/run_program.h"

namespace intaglio::testing {

struct MarkJudgement {
  std::size_t burnt = 0, doubled = 0, made = 0, uncertain = 0;
  std::size_t unknown = 0;   ///< burnt, and neither made nor uncertain
  std::size_t not_made = 0;  ///< made by the journal, and not burnt
};

class MarkShop {
 public:
  struct Options {
    std::string job;                   ///< its text; machine_file is added
    std::string profile = "galvo";     ///< of deploy/machines
    std::vector<std::string> up = {};  ///< arguments of `intaglio up`
    std::size_t mark_count = 0;        ///< of the job
  };

  /// Nothing is started yet. Files of the job lie in folder().
  MarkShop(Options options, std::filesystem::path folder);
  /// Closes the shop.
  ~MarkShop();
  MarkShop(const MarkShop&) = delete;
  MarkShop& operator=(const MarkShop&) = delete;

  /// `intaglio up`, until it is open.
  bool Open();
  /// Submits the job and arms it.
  bool Submit();
  /// What `intaglio show` says of it.
  const std::string& Show();
  bool IsIn(const std::string& state) const;
  /// Until it has ended. A job that is paused or waits for an arm is resumed, a shop that
  /// was closed is opened again.
  bool AwaitDone(std::chrono::seconds bound);
  /// True once the shop is open; opens it when it was closed.
  bool IsOpenOrOpens() { return IsOpen() || Open(); }
  /// Runs an `intaglio` command, and gives its output.
  std::string Type(const std::vector<std::string>& words);

  /// SIGKILL; "intaglio-up" is the program that started all others, which end with it.
  /// How many processes were hit.
  int Kill(const std::string& program);

  std::size_t BurntTicks() const;
  MarkJudgement Judge() const;

  const std::filesystem::path& folder() const { return folder_; }
  std::string UpOutput() const { return up_ ? up_->Output() : ""; }
  const std::string& shown() const { return shown_; }

 private:
  bool IsOpen() { return up_ && up_->running(); }
  std::vector<std::string> With(std::vector<std::string> words) const;
  /// The records of this and of earlier openings of the shop.
  std::vector<std::filesystem::path> Records() const;
  std::vector<formats::PointOutcome> LastOutcomes() const;

  Options options_;
  std::filesystem::path folder_;
  std::string tag_, shown_;
  int opened_ = 0;
  std::unique_ptr<Running> up_;
};

/// A drawing of circles of 1 mm in rows of 20.
std::string CirclesSvg(std::size_t count);

}  // namespace intaglio::testing
