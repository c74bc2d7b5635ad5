#pragma once

// The processes of one shop: job service, discretizer, sorter, and the cell of one
// machine (synchronizer, motion bridge), with the virtual engraver in the machine's
// place if it is asked for. `intaglio run` has a private one, `intaglio up` a public one.

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "proto/truth.pb.h"
#include "services/client/child_process.h"
#include "services/client/job_client.h"
#include "services/client/shop/kept_process.h"
#include "services/platform/bus/bus.h"

namespace intaglio::client {

/// The virtual engraver and how it behaves.
struct VirtualMachine {
  MachineTruth truth;               ///< see virtual_truth.h
  std::string speed = "1";          ///< "1", "N" (times real time) or "lockstep"
  std::vector<std::string> faults;  ///< "AT_TICK COMMAND", as --fault of virtual-engraver
};

/// Who may log in to the web console of a shop; in its folder.
inline constexpr char kConsoleUsersFile[] = "console.users";

/// A web console beside the services (docs/console.md).
struct ConsoleSetting {
  int port = -1;                         ///< 0: a free one; -1: no console
  std::string address;                   ///< empty: this computer alone
  std::string certificate, private_key;  ///< PEM files; empty: not encrypted
  std::string users;                     ///< file; empty: kConsoleUsersFile
  std::string webhooks;                  ///< file of receivers; empty: none
};

struct ServiceSetOptions {
  std::filesystem::path folder;   ///< sockets, logs, database; made anew
  std::filesystem::path results;  ///< job folders
  std::filesystem::path materials_db;
  MachineSpec machine;
  bus::BusOptions bus;
  std::set<std::string> without;    ///< services that run elsewhere, e.g. "discretizer"
  std::filesystem::path recording;  ///< file of a recorder; empty: none
  std::string recording_bulk;       ///< all (""), thin or none, as its --bulk
  bool die_with_parent = true;
  ConsoleSetting console;
};

/// `machine` with what was taught when the shop in `folder` was open before, unless its
/// own taught positions are newer, or those do not fit it any more.
MachineSpec WithKeptTaught(const std::filesystem::path& folder,
                           const MachineSpec& machine);

/// Whether there is a virtual machine in place of this one: kUnsupported.
Status CheckVirtual(const MachineSpec& spec, const VirtualMachine& machine);

class ServiceSet {
 public:
  /// Starts everything; on failure what was started is ended again.
  static Result<ServiceSet> Start(const ServiceSetOptions& options,
                                  const VirtualMachine* virtual_machine);

  /// The machine profile as the cell uses it: with the lines of the virtual engraver.
  const MachineSpec& machine() const { return machine_; }
  const std::filesystem::path& machine_file() const { return machine_file_; }
  const std::filesystem::path& glass_record() const { return glass_record_; }
  const std::filesystem::path& panel() const { return panel_; }
  /// Waits until every service has reported that it is ready or at work. While services
  /// of the shop become ready one after the other, it waits on; when none has for 30 s
  /// (patience.h), kTimedOut with the names of those of this set that have not. kFault
  /// with the last output of one that has died.
  Status AwaitReady(JobClient& client);
  /// The address of the web console, once pages can be opened. kFault with its last
  /// output when it has ended, kTimedOut.
  Result<std::string> AwaitConsole();
  /// Starts the services again that have ended by themselves, and reports which. kFault
  /// with its last output when it was the machine, or a service that does so again and
  /// again.
  Result<std::vector<std::string>> Revive();
  /// Asks all services to end, and waits for none.
  void Terminate();
  /// Tells all services to end, and waits for those that make something, then for the
  /// machine, so that the glass has everything. The recorder still writes what the others
  /// reported at their end.
  void EndMaking();
  /// EndMaking, and waits for the recorder: the recording is whole.
  void Stop();
  /// "name pid" of each process.
  std::vector<std::string> Processes();

 private:
  Status StartEngraver(const ServiceSetOptions& options, const VirtualMachine& machine);
  Status StartService(const ServiceSetOptions& options, const std::string& name,
                      const std::vector<std::string>& arguments);
  Status StartConsole(const ServiceSetOptions& options);
  Status Keep(const ServiceSetOptions& options, const std::string& name,
              std::vector<std::string> arguments);
  Status AwaitLines();
  /// The service is of the shop, or of this cell.
  bool IsOurs(const ServiceView& service) const;

  MachineSpec machine_;
  std::filesystem::path machine_file_, glass_record_, panel_;
  std::set<std::string> without_;
  bool records_ = false;
  std::filesystem::path console_address_;
  std::string console_address_before_;  ///< what the file had before it was started
  std::vector<std::unique_ptr<ChildProcess>> engraver_;  // none or one
  std::vector<std::unique_ptr<KeptProcess>> services_;
};

}  // namespace intaglio::client
