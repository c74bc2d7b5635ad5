#pragma once

// A line between two programs of one computer over a Unix-domain socket: the host's end,
// and the listener of the program that stands for the device.
//
// The socket is a file of mode 0600 in a folder of mode 0700: only programs of the same
// user can open it. A program that was killed leaves its file; the next listener replaces
// it. A program that hangs keeps its connection: silence is found by the frames
// (reliable_link.h).

#include <memory>
#include <string>

#include "services/platform/link/byte_stream.h"

namespace intaglio::link {

/// Longest path of a socket, bytes: the system's sockaddr_un.
inline constexpr std::size_t kMaxUnixPath = 107;

/// kInvalidValue: `path` is not absolute, or too long.
Status CheckUnixPath(const std::string& path);

/// kIo when nobody listens there; the message names the path and the remedy.
Result<std::unique_ptr<ByteStream>> OpenUnix(const std::string& path);

/// Not thread-safe. Nothing blocks.
class UnixListener {
 public:
  /// Makes the folder, too, when it is missing. kIo: another program listens there
  /// already, or the folder belongs to another user or is open to others.
  static Result<std::unique_ptr<UnixListener>> Listen(const std::string& path);
  UnixListener(const UnixListener&) = delete;
  UnixListener& operator=(const UnixListener&) = delete;
  /// Removes the file.
  ~UnixListener();

  /// The next host, or null.
  std::unique_ptr<ByteStream> Accept();
  /// For poll(2).
  int fd() const { return socket_; }

 private:
  UnixListener(int socket, std::string path);
  int socket_;
  std::string path_;
};

}  // namespace intaglio::link
