#include "services/platform/command_line/standard_streams.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

namespace intaglio::command_line {

void KeepStandardStreams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is this one. Opened the other way round, it refuses its use.
    if (open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream) return;
  }
}

Status FlushOutput() {
  errno = 0;
  std::cout.flush();
  const bool flushed = std::fflush(stdout) == 0;
  const int cause = errno;
  if (flushed && std::cout.good() && std::ferror(stdout) == 0) return {};
  return Fail(ErrorCode::kIo,
              fmt::format("the standard output cannot be written{}: what was printed "
                          "there is not whole; free space, or choose another file",
                          cause == 0 ? "" : fmt::format(" ({})", std::strerror(cause))));
}

}  // namespace intaglio::command_line
