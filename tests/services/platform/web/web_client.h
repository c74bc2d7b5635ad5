#pragma once

// A client of a web server on this computer, for tests: sends exactly the bytes it is
// given.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace intaglio::test {

/// A TCP connection to 127.0.0.1.
class WebConnection {
 public:
  explicit WebConnection(std::uint16_t port, int receive_buffer_bytes = 0);
  ~WebConnection();
  WebConnection(WebConnection&& other) noexcept;
  WebConnection& operator=(WebConnection&&) = delete;
  void Send(const std::string& bytes) const;
  /// What has come until `text` is in it, or the time is up, or the other side ended;
  /// what follows it is kept for the next call.
  std::string ReadUntil(const std::string& text, std::chrono::milliseconds bound);
  std::string ReadBytes(std::size_t count, std::chrono::milliseconds bound);
  /// The other side ends within the time.
  bool Ends(std::chrono::milliseconds bound);

 private:
  /// False: nothing more comes within the time.
  bool Receive(std::chrono::steady_clock::time_point end);
  int socket_ = -1;
  bool ended_ = false;
  std::string kept_;
};

struct WebAnswer {
  int status = 0;  ///< 0: none came
  std::string headers, body;
  double seconds = 0;
};

struct WebQuestion {
  std::string method = "GET", path = "/", key = {}, body = {};
  std::string headers = {};  ///< further lines, each with its "\r\n"
  std::string host = {};     ///< empty: 127.0.0.1 and the port
};
WebAnswer Ask(std::uint16_t port, const WebQuestion& question);

/// The request of a WebSocket's handshake.
std::string Upgrade(std::uint16_t port, const std::string& path, const std::string& key,
                    const std::string& headers = {});
/// A masked text frame of fewer than 126 bytes.
std::string Frame(const std::string& text);
/// The text of the next frame; nullopt: none within the time.
std::optional<std::string> ReadFrame(WebConnection& connection,
                                     std::chrono::milliseconds bound);

}  // namespace intaglio::test
