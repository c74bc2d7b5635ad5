#pragma once

// The emergency stops of one machine, as a process that listens to EmergencyStop holds
// them. A press has a source (the process that sent it) and a number, which grows within
// the source. Of each source the latch keeps two numbers, the highest pressed and the
// highest released: pressed while the first is greater for any source. Both only grow, so
// the same samples give the same latch in whatever order and however often they arrive:
//
//   - a press stays until a reset names it, whatever becomes of its sender;
//   - a reset releases the presses that it names, and those of lower numbers of the same
//     source, which that source had sent before; it can come before the press does;
//   - no clock takes part.
//
// A press that a reset names before it was received stops once all the same: Take returns
// true for the first sample that names a press, so that a reset which is read together
// with its press cannot hide it.
//
// A reset may reach one listener of a machine and not another, when it is deleted before
// all have discovered it. So a listener can report the presses that it holds (TakeHeld):
// the latch takes these for presses, and holds them as long as they are reported, so that
// it can report them to the next reset.
//
// Memory is bounded by kMaxSources. What is forgotten is released already, longest ago
// first: if such a press came again it would stop again. When all of them are held, a
// further press holds the latch without a name, until the process starts anew.
//
// Used from one thread.

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "idl/safety.h"

namespace intaglio::host {

struct StopPress {
  std::string source;
  std::uint64_t number = 0;
  bool operator==(const StopPress&) const = default;
};

/// For a sample, which borrows the names of `presses`.
std::vector<intaglio_StopPress> WireOf(const std::vector<StopPress>& presses);
std::vector<intaglio_StopPress> WireOf(std::vector<StopPress>&&) = delete;

class StopLatch {
 public:
  static constexpr std::size_t kMaxSources = 128;
  static constexpr std::size_t kMaxSourceLength = 512;  ///< longer: held without a name

  /// True when it names a press that was not known: the machine stops now, whether or not
  /// the latch is pressed afterwards. Likewise the others.
  bool Receive(const intaglio_EmergencyStop& sample);
  /// Everything that another listener of the same machine holds; empty: nothing.
  bool TakeHeld(std::string_view listener, std::span<const intaglio_StopPress> presses);
  /// Number 0, which no sender gives, is taken for 1.
  bool TakePress(std::string_view source, std::uint64_t number);
  bool TakeRelease(std::string_view source, std::uint64_t number);

  bool pressed() const { return unnamed_ || !held_.empty(); }
  /// By source, each with its highest number that is held.
  const std::vector<StopPress>& held() const { return held_; }
  /// Grows when held() or pressed() changes.
  std::uint64_t revision() const { return revision_; }

 private:
  struct Numbers {
    std::uint64_t pressed = 0, released = 0;
    std::uint64_t changed_at = 0;  // by changes_
    bool held() const { return pressed > released; }
  };
  /// Null when there is no room.
  Numbers* Find(std::string_view source);
  bool HoldUnnamed();
  void UpdateHeld();

  std::map<std::string, Numbers, std::less<>> sources_;
  std::map<std::string, std::vector<StopPress>, std::less<>> elsewhere_;
  std::vector<StopPress> held_;
  bool unnamed_ = false;
  std::uint64_t changes_ = 0, revision_ = 0;
};

}  // namespace intaglio::host
