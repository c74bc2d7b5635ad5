#pragma once

// A shop and its machine, of any row of the table, as processes. The controller is a
// process apart from the shop, as a real one is: it survives whatever is done to the
// services, and its own record of true places is the judge.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/integration/campaign/machine_rows.h"
#include "tests/integration/run_program.h"

namespace intaglio::campaign {

class MachineUnderFire {
 public:
  /// Starts the machine. `tag`: of the bus, and of no other shop.
  MachineUnderFire(const MachineRow& row, std::filesystem::path folder, std::string tag);
  /// Closes the shop.
  ~MachineUnderFire();
  MachineUnderFire(const MachineUnderFire&) = delete;
  MachineUnderFire& operator=(const MachineUnderFire&) = delete;

  /// Whether it is open then; also again, after it was killed.
  bool OpenShop();
  bool Submit();
  std::string Type(const std::string& words) const;
  /// What `intaglio show` says of the job.
  const std::string& Show();
  bool IsIn(const std::string& state) const;
  /// What a person does at a computer that was too busy for its line: opens the shop,
  /// sets a zero that the job asks for, resumes a paused job, arms one that waits.
  void GoOn();
  /// The same until the job is done.
  bool AwaitDone(std::chrono::seconds bound);
  bool AwaitState(const std::string& state, std::chrono::seconds bound);

  /// What the row does to it, and sets it right again.
  void Act(const FaultRow& fault) { Do(fault, fault.act, true); }
  void SetRight(const FaultRow& fault) { Do(fault, fault.set_right, false); }

  /// A person drives the tool to the true zero, dark, and sets it. What was answered, if
  /// it was refused.
  std::string SetZero() const;

  /// All work so far.
  std::vector<WorkPiece> Work() const { return row_.work(records()); }
  /// Bytes of its record: every motion, every turn of a spindle, every light adds some.
  std::uintmax_t Activity() const;
  /// Where the mirrors of a scan head point, which its record of what it burns lacks;
  /// empty: it has none.
  std::string Mirrors() const;
  Result<Account> Judge(const std::vector<WorkPiece>& before) const;
  std::string Log() const { return shop_ ? shop_->Output() : ""; }

 private:
  Records records() const;
  /// True, of the tool, at rest.
  Vec3 Place() const;
  /// Empty, or why it does not come there.
  std::string DriveTo(int axis, double to_mm) const;
  void StartMachine();
  void WriteProfile() const;
  std::vector<std::string> OnTheBus(std::vector<std::string> words) const;
  bool IsOpen() { return shop_ && shop_->running(); }
  void Do(const FaultRow& fault, const std::string& what, bool acts);
  void SwitchPower(bool on);
  void Kill(const std::string& service);

  const MachineRow& row_;
  std::filesystem::path folder_;
  std::string tag_, socket_, shown_;
  int opened_ = 0, powered_ = 0;
  std::unique_ptr<testing::Running> machine_, shop_;
};

}  // namespace intaglio::campaign
