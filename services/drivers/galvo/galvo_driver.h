#pragma once

// Driver of a scan head's controller (services/platform/link/scan_head_protocol.h) for
// marks: services/drivers/interface/mark_driver.h.
//
// A mark waits here until its kBegun was taken by TakeEvents; then its ticks are sent, at
// most scan_head.ahead_ms before they are played. A mark whose kBegun was taken can still
// end as kNotBegun: the controller dropped it before its beginning, and says so.
// On a web a mark is made when its places are in the field; when it has left the field
// before, the run stops with a fault that names the mark. With a photo eye a repeat lies
// by its own print mark; without one it is left out (kNoPrintMark), or ends the run.
//
// K11: a controller in lockstep can_hold: no ticks are sent, so its time does not pass.

#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/galvo/mark_player.h"
#include "services/drivers/galvo/print_tracker.h"
#include "services/drivers/interface/mark_driver.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/expected_device.h"
#include "services/platform/link/line_session.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class GalvoDriver final : public MarkDriver {
 public:
  /// `broken`: what is wrong with the profile; then nothing is sent. Empty: nothing is.
  GalvoDriver(const MachineSpec& machine,
              std::optional<galvo::CorrectionTable> correction, std::string broken,
              link::StreamOpener open, link::SteadyClock clock)
      : head_(machine.scan_head()),
        expected_{machine.mark_line().serial_number(), "scan head", machine.name(),
                  machine.mark_line().device(), "mark_line"},
        broken_(std::move(broken)),
        clock_(clock),
        session_(std::move(open), std::move(clock)),
        player_(machine.scan_head(), std::move(correction)) {}

  void Poll() override;
  int fd() const override { return session_.fd(); }
  const MarkDeviceState& state() const override { return state_; }
  std::vector<MarkEvent> TakeEvents() override;
  Status Permit(bool permitted) override;
  Status Hold() override;
  Status UseEye(const std::optional<PrintEye>& eye) override;
  Status Begin(std::uint32_t run, std::span<const mark::Pen> pens) override;
  std::size_t Room() const override;
  Status Append(const NumberedMark& mark) override;
  Status Finish() override;
  Status Pause() override;
  Status Stop() override;
  Status Reset() override;
  Status RequestPast(std::uint32_t run, std::uint32_t first,
                     std::uint32_t count) override;

 private:
  void Handle(link::HeadFrame type, std::span<const std::byte> payload);
  void Identify(std::span<const std::byte> payload);
  void Refuse(const std::string& why);
  void TakeStatus(const link::HeadStatus& status);
  void TakeMarks(const link::HeadMarks& marks);
  void TakePast(const link::HeadPast& past);
  void TakeWeb(const link::HeadWeb& web);
  void TakePrint(const link::HeadPrint& print);
  /// All before it have come, else the run ends.
  void ExpectPrint(std::uint32_t number);
  std::string PrintText() const;
  void BeginSession();
  void EndRun(const std::string& fault);
  void DropWaiting();
  void Announce();
  void Pump();
  bool SendNext();
  enum class Next { kLoaded, kLeftOut, kNothing };
  /// Takes the mark that is next.
  Next LoadNext();
  /// The print mark of its repeat: where it lies, left out, or not yet known.
  Next FindPrintMark(const NumberedMark& mark, std::optional<double>& origin_count);
  void LeaveOut(const NumberedMark& mark);
  void DropFront();
  bool SendBlock(link::HeadBlock block);
  void StopFor(const std::string& fault);
  std::uint64_t TickNow() const;
  std::uint64_t FirstTick(std::uint64_t now, bool web) const;
  Status SendFrame(link::HeadFrame type, const link::Bytes& payload = {});
  Status SendDrop(link::HeadFrame type, const link::Bytes& payload = {});
  void UpdateState();

  ScanHead head_;
  link::ExpectedDevice expected_;
  std::string broken_;  // of the profile: nothing is sent
  link::SteadyClock clock_;
  link::LineSession session_;
  MarkPlayer player_;
  std::optional<PrintEye> eye_;  // of the runs
  PrintTracker prints_;
  std::optional<std::uint32_t> next_print_;  // number of the next, in this session
  std::uint64_t begin_tick_ = 0;             // of the run: what passed before is not used
  std::string skipped_;                      // repeats without a print mark
  std::uint32_t skipped_count_ = 0;          // of them
  std::uint32_t last_skipped_ = 0;
  MarkDeviceState state_;
  std::string refusal_, fault_;
  bool identified_ = false, identified_now_ = false;
  std::uint32_t polled_sessions_ = 0;
  link::HeadIdentity identity_;
  link::HeadStatus status_;
  std::uint64_t statuses_ = 0;
  std::chrono::nanoseconds status_at_{0}, permitted_at_{0};
  bool permit_due_ = false;  // the line was full of blocks
  std::uint32_t drops_sent_ = 0;
  std::uint32_t credit_ = 0;  // ticks, of the newest status
  std::vector<MarkEvent> events_;

  bool active_ = false;     // a run was begun and has not ended
  bool finishing_ = false;  // Finish was called
  bool finish_sent_ = false;
  bool ending_ = false;   // Stop, or a fault of its own
  bool held_ = false;     // no ticks are sent before the next permission
  bool pausing_ = false;  // the ticks of the mark in hand are still sent
  std::uint32_t run_ = 0;
  std::deque<NumberedMark> waiting_;  // the first announced_ of them with kBegun
  std::size_t announced_ = 0, taken_ = 0;
  std::map<std::uint32_t, bool> open_;  // marks that are not ended; begun here
  std::uint64_t next_tick_ = 0;         // behind the ticks that were sent
};

std::unique_ptr<MarkDriver> MakeGalvoDriver(const MachineSpec& machine,
                                            link::StreamOpener open,
                                            link::SteadyClock clock);

}  // namespace intaglio::drivers
