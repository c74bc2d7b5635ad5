// The server in this process, asked by raw connections.

#include "services/platform/web/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "tests/patience.h"
#include "tests/services/platform/web/web_client.h"

namespace intaglio::web {
namespace {

using namespace std::chrono_literals;
using test::Ask;
using test::WebConnection;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class WebServer : public ::testing::Test {
 protected:
  void Open(Limits limits = {}) {
    ServerOptions options;
    options.key = "key";
    options.pages["/"] = TextResponse(200, "text/html; charset=utf-8", "page");
    options.event_paths = {"/events"};
    options.socket_paths = {"/socket"};
    options.long_paths = {"/long"};
    options.limits = limits;
    Handlers handlers;
    handlers.request = [this](const Request& request, Reply reply) {
      ++asked_;
      if (request.target.path != "/never")
        reply(TextResponse(200, "text/plain", request.method + request.body));
    };
    handlers.body = [this](const Request& request, std::uint64_t body_bytes,
                           Reply reply) -> std::shared_ptr<BodySink> {
      if (request.target.path == "/long/refused") {
        reply(TextResponse(403, "text/plain", "refused"));
        return nullptr;
      }
      return std::make_shared<CountingSink>(*this, body_bytes, std::move(reply));
    };
    handlers.refusal = refusal_;
    handlers.greeting = [](const std::string& path) { return "hello " + path; };
    handlers.message = [this](PeerId peer, const Caller&, const std::string& text) {
      server_->Send(peer, "echo " + text);
    };
    auto opened = Server::Open(options, handlers);
    ASSERT_TRUE(opened) << opened.error().message;
    server_ = std::move(*opened);
    thread_ = std::thread([this] { server_->Run(); });
  }
  ~WebServer() override {
    if (!server_) return;
    server_->Stop();
    thread_.join();
  }
  std::uint16_t port() const { return server_->port(); }

  std::unique_ptr<Server> server_;
  std::thread thread_;
  decltype(Handlers::refusal) refusal_;
  std::atomic<int> asked_ = 0;
  std::atomic<std::size_t> largest_piece_ = 0;
  std::atomic<int> broken_ = 0;

 private:
  /// Answers how much came; refuses a body at its first '!'.
  class CountingSink : public BodySink {
   public:
    CountingSink(WebServer& test, std::uint64_t body_bytes, Reply reply)
        : test_(test), body_bytes_(body_bytes), reply_(std::move(reply)) {}
    ~CountingSink() override { test_.broken_ += answered_ ? 0 : 1; }
    void Receive(std::string bytes, std::function<void()> taken) override {
      test_.largest_piece_ = std::max<std::size_t>(test_.largest_piece_, bytes.size());
      count_ += bytes.size();
      if (bytes.find('!') != std::string::npos) {
        answered_ = true;
        return reply_(TextResponse(409, "text/plain", "no !"));
      }
      // From another thread, as a disk's would be.
      std::thread(std::move(taken)).detach();
    }
    void End() override {
      answered_ = true;
      reply_(TextResponse(200, "text/plain",
                          std::to_string(count_) + " of " + std::to_string(body_bytes_)));
    }

   private:
    WebServer& test_;
    std::uint64_t body_bytes_;
    Reply reply_;
    std::size_t count_ = 0;
    bool answered_ = false;
  };
};

TEST_F(WebServer, TakesALongBodyPieceByPiece) {
  Open();
  const auto send = [&](const std::string& path, const std::string& body,
                        const std::string& headers = {}) {
    return Ask(
        port(),
        {.method = "POST", .path = path, .key = "key", .body = body, .headers = headers});
  };
  const std::string large(5'000'000, 'x');
  const auto answer = send("/long/file", large);
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, "5000000 of 5000000");
  EXPECT_LE(largest_piece_, 65536u) << "never the whole";
  EXPECT_EQ(send("/long/file", "").body, "0 of 0");
  // The answer is read although the client has sent everything before it reads.
  const auto refused = send("/long/refused", std::string(300'000, 'x'));
  EXPECT_EQ(refused.status, 403);
  EXPECT_EQ(refused.body, "refused");
  EXPECT_EQ(send("/long/file", std::string(100'000, '!')).status, 409);
  EXPECT_EQ(send("/long/file", "x", "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(Ask(port(), {.method = "POST", .path = "/long/file", .body = "x"}).status,
            401);
  EXPECT_EQ(broken_, 0);
}

TEST_F(WebServer, ALongBodyThatBreaksOffEndsItsSink) {
  Open();
  {
    WebConnection connection(port());
    connection.Send(
        "POST /long/file HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port()) +
        "\r\nAuthorization: Bearer key\r\nContent-Length: 1000000\r\n"
        "Expect: 100-continue\r\n\r\n");
    EXPECT_THAT(connection.ReadUntil("\r\n\r\n", 10s), HasSubstr("100 Continue"));
    connection.Send(std::string(1000, 'x'));
  }
  for (int i = 0; i < 1000 && broken_ == 0; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(broken_, 1);
  EXPECT_EQ(Ask(port(), {}).status, 200);
}

TEST_F(WebServer, RefusesInTheFormOfItsUser) {
  refusal_ = [](int status, const std::string& sentence) {
    return TextResponse(status, "application/json", "[\"" + sentence + "\"]");
  };
  Open();
  for (const char* const path : {"/x", "/events", "/socket"}) {
    const auto refused = Ask(port(), {.path = path, .key = "kez"});
    EXPECT_EQ(refused.status, 401);
    EXPECT_THAT(refused.body, StartsWith("[\"log in, ")) << path;
    EXPECT_THAT(refused.headers, HasSubstr("application/json"));
  }
}

TEST_F(WebServer, ServesPagesToAllAndTheRestToTheKey) {
  Open();
  const auto page = Ask(port(), {});
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "page");
  EXPECT_THAT(page.headers, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page.headers, HasSubstr("nosniff"));
  EXPECT_EQ(Ask(port(), {.path = "/x"}).status, 401);
  EXPECT_EQ(Ask(port(), {.path = "/x", .key = "kez"}).status, 401);
  EXPECT_EQ(asked_, 0);
  const auto post =
      Ask(port(), {.method = "POST", .path = "/x", .key = "key", .body = "abc"});
  EXPECT_EQ(post.body, "POSTabc");
  EXPECT_EQ(Ask(port(), {.method = "DELETE", .path = "/x", .key = "key"}).status, 405);
}

TEST_F(WebServer, TheKeyOfTheAddressBecomesACookie) {
  Open();
  const auto redirect = Ask(port(), {.path = "/?key=key"});
  EXPECT_EQ(redirect.status, 303);
  const std::string cookie = "intaglio_" + std::to_string(port()) + "=key";
  EXPECT_THAT(redirect.headers,
              HasSubstr(cookie + "; Path=/; HttpOnly; SameSite=Strict"));
  EXPECT_THAT(Ask(port(), {.path = "/?key=wrong"}).headers, Not(HasSubstr("Cookie")));
  EXPECT_EQ(Ask(port(), {.path = "/x", .headers = "Cookie: " + cookie + "\r\n"}).status,
            200);
}

TEST_F(WebServer, RefusesForeignHostsAndOriginsEvenWithTheKey) {
  Open();
  EXPECT_EQ(Ask(port(), {.path = "/x", .key = "key", .host = "evil.example"}).status,
            421);
  EXPECT_EQ(Ask(port(), {.key = "key", .host = "evil.example"}).status, 421);
  const std::string own = "Origin: http://127.0.0.1:" + std::to_string(port()) + "\r\n";
  const std::string foreign = "Origin: http://evil.example\r\n";
  for (const char* method : {"GET", "POST"}) {
    const auto status_with = [&](const std::string& headers) {
      return Ask(port(),
                 {.method = method, .path = "/x", .key = "key", .headers = headers})
          .status;
    };
    EXPECT_EQ(status_with(foreign), 403);
    EXPECT_EQ(status_with("Origin: null\r\n"), 403);
    EXPECT_EQ(status_with(own + foreign), 403);
    EXPECT_EQ(status_with(own), 200);
  }
  WebConnection socket(port());
  socket.Send(test::Upgrade(port(), "/socket", "key", foreign));
  EXPECT_THAT(socket.ReadUntil("\r\n\r\n", 10s), HasSubstr(" 403 "));
}

TEST_F(WebServer, RefusesWhatIsTooLargeOrBroken) {
  Open({.header_bytes = 1000, .body_bytes = 100});
  EXPECT_EQ(Ask(port(), {.headers = "X: " + std::string(2000, 'a') + "\r\n"}).status,
            431);
  EXPECT_EQ(
      Ask(port(),
          {.method = "POST", .path = "/x", .key = "key", .body = std::string(200, 'a')})
          .status,
      413);
  EXPECT_EQ(Ask(port(), {.path = "/../../etc/passwd", .key = "key"}).status, 400);
  EXPECT_EQ(Ask(port(), {.path = "/%2e%2e/etc/passwd", .key = "key"}).status, 400);
  WebConnection broken(port());
  broken.Send("no request at all\r\n\r\n");
  EXPECT_TRUE(broken.Ends(10s));
  EXPECT_EQ(asked_, 0);
  EXPECT_EQ(Ask(port(), {}).status, 200);
}

TEST_F(WebServer, AWebSocketGreetsAndAnswers) {
  Open();
  WebConnection socket(port());
  socket.Send(test::Upgrade(port(), "/socket", "key"));
  EXPECT_THAT(socket.ReadUntil("\r\n\r\n", 10s), HasSubstr(" 101 "));
  EXPECT_EQ(test::ReadFrame(socket, 10s), "hello /socket");
  socket.Send(test::Frame("a"));
  EXPECT_EQ(test::ReadFrame(socket, 10s), "echo a");
  server_->Publish("/socket", "news");
  EXPECT_EQ(test::ReadFrame(socket, 10s), "news");
  socket.Send(std::string(20, '\xff'));  // no frame
  EXPECT_TRUE(socket.Ends(10s));
}

TEST_F(WebServer, AnEventStreamHasALineForEach) {
  Open();
  WebConnection events(port());
  events.Send("GET /events HTTP/1.1\r\nHost: localhost:" + std::to_string(port()) +
              "\r\nAuthorization: Bearer key\r\n\r\n");
  EXPECT_THAT(events.ReadUntil("\r\n\r\n", 10s), HasSubstr("text/event-stream"));
  EXPECT_EQ(events.ReadUntil("\n\n", 10s), "data: hello /events\n\n");
  server_->Publish("/events", "{}");
  EXPECT_EQ(events.ReadUntil("\n\n", 10s), "data: {}\n\n");
}

// Such a reader costs what the limit allows, and then its connection.
TEST_F(WebServer, ASlowReaderIsDisconnectedAndDelaysNobody) {
  Open({.queue_bytes = 1 << 20});
  WebConnection slow(port(), 4096);
  slow.Send("GET /events HTTP/1.1\r\nHost: localhost:" + std::to_string(port()) +
            "\r\nAuthorization: Bearer key\r\n\r\n");
  ASSERT_THAT(slow.ReadUntil("hello", 10s), HasSubstr("hello"));
  for (int i = 0; i < 200; ++i) {
    server_->Publish("/events", std::string(100'000, 'a'));
    if (i % 20 == 0) {
      EXPECT_EQ(Ask(port(), {}).status, 200);
    }
  }
  EXPECT_TRUE(slow.Ends(20s));
}

TEST_F(WebServer, HalfOpenConnectionsEndAndKeepNobodyOut) {
  Open({.connection_count = 50, .request_time = 1000ms});
  std::vector<WebConnection> half_open;
  for (int i = 0; i < 200; ++i) {
    half_open.emplace_back(port());
    half_open.back().Send("GET / HTTP/1.1\r\nHost: lo");
  }
  EXPECT_EQ(Ask(port(), {}).status, 200);
  EXPECT_TRUE(half_open.front().Ends(10s));
  EXPECT_TRUE(half_open.back().Ends(10s));
}

TEST_F(WebServer, AHandlerThatNeverAnswersEndsByTime) {
  Open({.answer_time = 100ms});
  EXPECT_EQ(Ask(port(), {.path = "/never", .key = "key"}).status, 504);
}

TEST_F(WebServer, MorePeersThanAllowedAreRefused) {
  Open({.peer_count = 1});
  WebConnection first(port());
  first.Send(test::Upgrade(port(), "/socket", "key"));
  EXPECT_EQ(first.ReadUntil("hello", 10s).find(" 101 "), 8u);
  WebConnection second(port());
  second.Send(test::Upgrade(port(), "/socket", "key"));
  EXPECT_THAT(second.ReadUntil("\r\n\r\n", 10s), HasSubstr(" 503 "));
}

TEST(WebServerAddress, ANetworkIsRefusedByName) {
  const auto why_not = [](const std::string& address) {
    ServerOptions options;
    options.address = address;
    options.key = "key";
    const auto opened = Server::Open(options, {});
    return opened ? std::string() : opened.error().message;
  };
  for (const char* address : {"0.0.0.0", "192.168.1.4", "::"})
    EXPECT_THAT(why_not(address), HasSubstr("only an address of this computer"));
  for (const char* address : {"shop.example", ""})
    EXPECT_THAT(why_not(address), HasSubstr("give an IP address"));
}

TEST(WebServerAddress, AUsedPortIsNamed) {
  ServerOptions options;
  options.key = "key";
  const auto first = Server::Open(options, {});
  ASSERT_TRUE(first);
  options.port = (*first)->port();
  const auto second = Server::Open(options, {});
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("choose another port"));
}

}  // namespace
}  // namespace intaglio::web
