#pragma once

// Which instances of services are counted of each process: the first kMaxOfProcess that
// live. A process is one service, or plays several in a test; a faulty one may write
// health under any number of names, and whoever remembers each would grow with them.

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace intaglio::host {

/// Not for use by two threads at once.
class ProcessInstances {
 public:
  static constexpr std::size_t kMaxOfProcess = 256;

  /// False: its process has too many. `instance` ends in the name of its participant
  /// (IsOwn, identity_role.h).
  bool Admit(std::string_view instance) {
    std::set<std::string, std::less<>>& known = instances_[ProcessOf(instance)];
    if (known.contains(instance)) return true;
    if (known.size() >= kMaxOfProcess) return false;
    known.emplace(instance);
    return true;
  }
  void End(std::string_view instance) {
    const auto found = instances_.find(ProcessOf(instance));
    if (found == instances_.end()) return;
    if (const auto known = found->second.find(instance); known != found->second.end())
      found->second.erase(known);
    if (found->second.empty()) instances_.erase(found);
  }

 private:
  static std::string ProcessOf(std::string_view instance) {
    return std::string(instance.substr(instance.rfind('-') + 1));
  }
  std::map<std::string, std::set<std::string, std::less<>>> instances_;
};

}  // namespace intaglio::host
