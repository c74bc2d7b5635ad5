#include "tests/services/platform/web/web_client.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <utility>

namespace intaglio::test {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

}  // namespace

WebConnection::WebConnection(std::uint16_t port, int receive_buffer_bytes)
    : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  if (receive_buffer_bytes > 0)
    setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes,
               sizeof receive_buffer_bytes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    ended_ = true;
}

WebConnection::WebConnection(WebConnection&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      ended_(other.ended_),
      kept_(std::move(other.kept_)) {}

WebConnection::~WebConnection() {
  if (socket_ >= 0) close(socket_);
}

void WebConnection::Send(const std::string& bytes) const {
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const auto count =
        send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) return;
    sent += static_cast<std::size_t>(count);
  }
}

bool WebConnection::Receive(Clock::time_point end) {
  if (ended_) return false;
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
  if (left <= 0ms) return false;
  pollfd polled{socket_, POLLIN, 0};
  if (poll(&polled, 1, static_cast<int>(left.count())) <= 0) return false;
  char bytes[65536];
  const auto count = recv(socket_, bytes, sizeof bytes, 0);
  if (count <= 0) {
    ended_ = true;
    return false;
  }
  kept_.append(bytes, static_cast<std::size_t>(count));
  return true;
}

std::string WebConnection::ReadUntil(const std::string& text,
                                     std::chrono::milliseconds bound) {
  const auto end = Clock::now() + bound;
  while (kept_.find(text) == std::string::npos && Receive(end)) {
  }
  const auto found = kept_.find(text);
  if (found == std::string::npos) return std::exchange(kept_, {});
  std::string read = kept_.substr(0, found + text.size());
  kept_.erase(0, read.size());
  return read;
}

std::string WebConnection::ReadBytes(std::size_t count, std::chrono::milliseconds bound) {
  const auto end = Clock::now() + bound;
  while (kept_.size() < count && Receive(end)) {
  }
  std::string read = kept_.substr(0, count);
  kept_.erase(0, read.size());
  return read;
}

bool WebConnection::Ends(std::chrono::milliseconds bound) {
  const auto end = Clock::now() + bound;
  while (Receive(end)) kept_.clear();
  return ended_;
}

WebAnswer Ask(std::uint16_t port, const WebQuestion& question) {
  const auto began = Clock::now();
  WebConnection connection(port);
  const std::string host =
      question.host.empty() ? "127.0.0.1:" + std::to_string(port) : question.host;
  std::string text = question.method + " " + question.path +
                     " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n" +
                     question.headers;
  if (!question.key.empty()) text += "Authorization: Bearer " + question.key + "\r\n";
  if (question.method == "POST")
    text += "Content-Length: " + std::to_string(question.body.size()) + "\r\n";
  connection.Send(text + "\r\n" + question.body);
  WebAnswer answer;
  answer.headers = connection.ReadUntil("\r\n\r\n", 30s);
  if (answer.headers.size() > 12) answer.status = std::atoi(answer.headers.c_str() + 9);
  const std::string length = "Content-Length: ";
  if (const auto at = answer.headers.find(length); at != std::string::npos) {
    const auto count =
        static_cast<std::size_t>(std::atoll(answer.headers.c_str() + at + length.size()));
    answer.body = connection.ReadBytes(count, 30s);
  }
  answer.seconds = std::chrono::duration<double>(Clock::now() - began).count();
  return answer;
}

std::string Upgrade(std::uint16_t port, const std::string& path, const std::string& key,
                    const std::string& headers) {
  return "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nAuthorization: Bearer " +
         key + "\r\n" + headers + "\r\n";
}

std::string Frame(const std::string& text) {
  std::string frame = {static_cast<char>(0x81), static_cast<char>(0x80 | text.size())};
  const std::string mask = "\x01\x02\x03\x04";
  frame += mask;
  for (std::size_t i = 0; i < text.size(); ++i)
    frame += static_cast<char>(text[i] ^ mask[i % 4]);
  return frame;
}

std::optional<std::string> ReadFrame(WebConnection& connection,
                                     std::chrono::milliseconds bound) {
  const std::string head = connection.ReadBytes(2, bound);
  if (head.size() < 2) return std::nullopt;
  std::size_t size = static_cast<unsigned char>(head[1]) & 0x7f;
  const std::size_t extra = size == 126 ? 2 : size == 127 ? 8 : 0;
  if (extra > 0) {
    size = 0;
    for (const char c : connection.ReadBytes(extra, bound))
      size = size * 256 + static_cast<unsigned char>(c);
  }
  std::string text = connection.ReadBytes(size, bound);
  // Pings of the server are passed over.
  if ((head[0] & 0x0f) != 1) return ReadFrame(connection, bound);
  return text;
}

}  // namespace intaglio::test
