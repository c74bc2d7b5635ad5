#include "services/console/audit_log.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <iostream>

#include "services/job/files/json_text.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::console {

void AuditLog::Add(ConsoleAudit entry) {
  if (file_.empty()) return;
  entry.set_time(host::UtcText(std::chrono::system_clock::now()));
  auto line = JsonTextOf(entry, JsonLayout::kOneLine);
  if (!line) {  // a path of a request that is not UTF-8
    entry.set_request("?");
    line = JsonTextOf(entry, JsonLayout::kOneLine);
  }
  if (line) queue_.Add([this, text = *line + "\n"] { Write(text); });
}

void AuditLog::Write(const std::string& line) {
  std::error_code error;
  if (std::filesystem::file_size(file_, error) >= max_bytes_ && !error)
    std::filesystem::rename(file_, file_.string() + ".1", error);
  const int descriptor =
      open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0600);
  const bool written = descriptor >= 0 && write(descriptor, line.data(), line.size()) ==
                                              static_cast<ssize_t>(line.size());
  const int why = errno;
  if (descriptor >= 0) close(descriptor);
  if (!written && !failed_)
    std::cerr << "cannot write " << file_.string() << ": " << std::strerror(why) << "\n";
  failed_ = !written;
}

}  // namespace intaglio::console
