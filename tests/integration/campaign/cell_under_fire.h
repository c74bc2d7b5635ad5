#pragma once

// A shop and a machine of a campaign's own. The machine is a process apart from the shop,
// as a real one is: it survives whatever is done to the services, and its glass is the
// judge.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "services/platform/bus/bus.h"
#include "tests/integration/run_program.h"

namespace intaglio::campaign {

/// State of glass and journal after a job, point by point.
struct Verdict {
  std::size_t points = 0;
  std::size_t made = 0;       ///< points with a crack
  std::size_t doubled = 0;    ///< points with more than one
  std::size_t stray = 0;      ///< cracks at no point
  std::size_t unknown = 0;    ///< points of which journal and glass disagree
  std::size_t uncertain = 0;  ///< points that the journal calls so
  /// Points that are not made, in agreement with the journal: passed by, and in the
  /// shadow of points made since.
  std::size_t skipped = 0;
  /// Points that the journal has at another tick than the glass.
  std::size_t mistimed = 0;
  std::uint64_t first_tick = 0, last_tick = 0;  ///< of its cracks; 0: none
  bool may_leave_uncertain = false;             ///< a person is asked about these
  bool may_be_unfinished = false;               ///< its block is out of the machine
  std::string trouble;  ///< a file that cannot be read; empty: none

  bool good() const {
    return trouble.empty() && points > 0 && doubled + stray + unknown == 0 &&
           (uncertain == 0 || may_leave_uncertain) &&
           (may_be_unfinished || 100 * skipped <= points);
  }
};

class CellUnderFire {
 public:
  /// `speed`: the machine's time against real time, or "lockstep"; `profile`: a supplied
  /// one that engraves points at the virtual lines.
  CellUnderFire(std::filesystem::path folder, std::string tag, const std::string& speed,
                std::string profile = "els-03");
  ~CellUnderFire();

  /// The shop's services, by `intaglio up`; also again, after all of them were killed.
  bool OpenShop();
  /// kill -9 of `intaglio up` and, with it, of every service; they are gone a moment
  /// later.
  void KillShop();
  void AwaitShopGone();
  /// Cuts that of the newest job at a byte of its last 64 KB that `choice` picks; its
  /// header and its first session, which are on the disk before the job is begun, remain.
  void CutJournal(std::uint32_t choice) const;
  /// A job of about 500 points, armed. The next one's block is another: its cracks are
  /// those that come from now on.
  /// `rate_hz` empty: the rate of its campaign.
  bool Submit(const std::string& rate_hz = "",
              const std::vector<std::string>& options = {});
  /// Another one beside it, which is not armed and not followed.
  void SubmitAnother(const std::vector<std::string>& options);
  /// The machine loses its power, a person puts another block in, and the power is back.
  void ChangeTheBlockOfADeadMachine();
  /// Cracks in that other block.
  std::size_t CracksOfTheNextBlock() const;
  /// State and message of the newest job as `intaglio show` has them.
  std::string Show();
  std::string Type(const std::vector<std::string>& words);
  /// One line for another on the machine's panel.
  std::string Press(const std::string& command) const;
  /// Where its services are to be found.
  bus::BusOptions bus_options() const;
  const char* cell() const { return profile_.c_str(); }
  /// At which its jobs are engraved, Hz.
  std::string rate_hz() const { return profile_ == "els-03" ? "100" : "1000"; }
  /// Starts this many watchers (`intaglio watch`) of the newest job, stopped from now on
  /// as long as the cell lives: they do not read what is written to them.
  void AddFrozenWatchers(int count);
  /// Process of a service, e.g. "intaglio-sorter"; 0: there is none.
  pid_t ProcessOf(const std::string& service) const;
  /// Cracks made so far.
  std::size_t Cracks() const;
  bool AwaitCracks(std::size_t count, std::chrono::milliseconds bound) const;
  /// Follows the job until it is done, resuming nothing by itself.
  bool AwaitDone(std::chrono::seconds bound);
  /// The same, and an operator who resumes what waits for one.
  bool AwaitDoneResuming(std::chrono::seconds bound);

  Verdict Judge() const;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  void StartMachine(const std::filesystem::path& glass);
  std::vector<std::string> SampleJob(const std::vector<std::string>& options) const;
  std::vector<std::string> OnTheBus(std::vector<std::string> words) const;
  std::filesystem::path JobFolder() const;
  bool AwaitEnd(std::chrono::seconds bound, bool resuming);

  std::filesystem::path folder_;
  std::string tag_, speed_, profile_;
  int jobs_ = 0;
  std::size_t cracks_before_ = 0;  // this job
  std::unique_ptr<testing::Running> machine_, shop_;
  std::vector<std::unique_ptr<testing::Running>> watchers_;
  int typed_ = 0;
};

}  // namespace intaglio::campaign
