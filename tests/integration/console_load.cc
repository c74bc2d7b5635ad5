#include "tests/integration/console_load.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <random>
#include <utility>

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using namespace std::string_literals;
using Clock = std::chrono::steady_clock;
using test::WebConnection;

constexpr int kSmallBuffer = 4096;  // bytes; what a slow reader's computer keeps
constexpr auto kPatience = 20s;
constexpr auto kFramePause = 10ms;  // between malformed frames

std::string Get(std::uint16_t port, const std::string& path, const std::string& key) {
  return "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
         "\r\nAuthorization: Bearer " + key + "\r\n\r\n";
}

/// Frames that RFC 6455 forbids a client to send.
const std::vector<std::string>& ForbiddenFrames() {
  static const std::vector<std::string> frames = {
      "\x81\x02{}"s,                                                 // not masked
      "\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\x00\x00\x00\x00"s,   // huge
      "\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff\x00\x00\x00\x00"s,   // 2^64 - 1
      "\xf1\x80\x00\x00\x00\x00"s,                                   // reserved bits
      "\x83\x80\x00\x00\x00\x00"s,                                   // unknown code
      "\x80\x80\x00\x00\x00\x00"s,                                   // continues nothing
      "\x09\x80\x00\x00\x00\x00"s,                                   // a ping in parts
      "\x89\xfe\x00\x7e\x00\x00\x00\x00"s + std::string(126, 'x'),   // a long ping
      "\x81\x82\x00\x00\x00\x00\xc3\x28"s,                           // not UTF-8
      "\x88\x81\x00\x00\x00\x00\x03"s,                               // half a code
      "\x81\xfe\x20\x00\x00\x00\x00\x00"s + std::string(8192, '{'),  // too long
  };
  return frames;
}

/// One whole answer is read; its status, 0 when none comes.
int ReadAnswer(WebConnection& connection) {
  const std::string headers = connection.ReadUntil("\r\n\r\n", kPatience);
  const std::string length = "Content-Length: ";
  const auto at = headers.find(length);
  if (at == std::string::npos) return 0;
  const auto count =
      static_cast<std::size_t>(std::atoll(headers.c_str() + at + length.size()));
  if (connection.ReadBytes(count, kPatience).size() < count) return 0;
  return std::atoi(headers.c_str() + 9);
}

}  // namespace

ConsoleLoad::ConsoleLoad(std::uint16_t port, std::string key, LoadOptions options)
    : port_(port), key_(std::move(key)), options_(std::move(options)) {
  const auto start = [&](auto method, auto... more) {
    threads_.emplace_back(
        [=, this](const std::stop_token& end) { (this->*method)(end, more...); });
  };
  start(&ConsoleLoad::KeepHalfOpen);
  start(&ConsoleLoad::KeepSlowReaders);
  start(&ConsoleLoad::SendMalformedFrames);
  for (int i = 0; i < options_.client_count; ++i) start(&ConsoleLoad::SendRequests, i);
}

void ConsoleLoad::KeepHalfOpen(const std::stop_token& end) {
  std::vector<std::unique_ptr<WebConnection>> open(
      static_cast<std::size_t>(options_.half_open_count));
  for (std::size_t next = 0; !end.stop_requested(); next = (next + 1) % open.size()) {
    const bool is_new = open[next] == nullptr;
    open[next] = std::make_unique<WebConnection>(port_);
    open[next]->Send(next % 2 == 0 ? "GET /api" : "POST /api/v1/stop HTTP/1.1\r\nHost:");
    if (!is_new) std::this_thread::sleep_for(10ms);
  }
}

WebConnection ConsoleLoad::SlowReader(int kind) const {
  WebConnection reader(port_, kSmallBuffer);
  if (kind == 0) reader.Send(test::Upgrade(port_, "/control", key_));
  if (kind == 1) reader.Send(Get(port_, "/api/v1/events", key_));
  if (kind == 2) reader.Send(Get(port_, "/view.js", key_));
  return reader;
}

void ConsoleLoad::KeepSlowReaders(const std::stop_token& end) {
  std::vector<std::unique_ptr<WebConnection>> open(
      static_cast<std::size_t>(options_.slow_reader_count));
  for (std::size_t next = 0; !end.stop_requested(); next = (next + 1) % open.size()) {
    const bool is_new = open[next] == nullptr;
    open[next].reset();
    open[next] = std::make_unique<WebConnection>(SlowReader(static_cast<int>(next % 3)));
    if (!is_new) std::this_thread::sleep_for(300ms);
  }
}

void ConsoleLoad::SendRequests(const std::stop_token& end, int client) {
  const std::vector<std::string> paths = {"/api/v1/status", "/api/v1/jobs", "/metrics",
                                          "/"};
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
          options_.client_count / options_.requests_per_second));
  auto connection = std::make_unique<WebConnection>(port_);
  auto next = Clock::now() + period * client / options_.client_count;
  for (auto i = static_cast<std::size_t>(client); !end.stop_requested(); ++i) {
    std::this_thread::sleep_until(next);
    const std::string request = Get(port_, paths[i % paths.size()], key_);
    connection->Send(request);
    int status = ReadAnswer(*connection);
    if (status == 0) {
      // The server may end a connection that rests just as a request comes on it, and a
      // client sends it again on a new one (RFC 9112, 9.3.1).
      connection = std::make_unique<WebConnection>(port_);
      connection->Send(request);
      status = ReadAnswer(*connection);
    }
    ++(status == 200 ? answered_ : refused_);
    // A client that was answered late does not catch up.
    next = std::max(next + period, Clock::now());
  }
}

void ConsoleLoad::SendMalformedFrames(const std::stop_token& end) {
  std::mt19937 random(38);
  for (std::size_t i = 0; !end.stop_requested(); ++i) {
    std::this_thread::sleep_for(kFramePause);
    WebConnection connection(port_);
    connection.Send(test::Upgrade(port_, "/control", key_));
    if (connection.ReadUntil("\r\n\r\n", kPatience).find(" 101 ") == std::string::npos)
      continue;
    const auto& forbidden = ForbiddenFrames();
    const std::size_t kind = i % (forbidden.size() + 1);
    if (kind < forbidden.size()) {
      connection.Send(forbidden[kind]);
      ++(connection.Ends(kPatience) ? broken_ : survived_);
      continue;
    }
    // Anything at all; it may be the beginning of a frame, so nothing ends it.
    std::string noise(512, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    connection.Send(noise);
  }
}

double Share(std::vector<double> values, double ratio) {
  if (values.empty()) return 0;
  const auto at =
      static_cast<std::ptrdiff_t>(ratio * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace intaglio::testing
