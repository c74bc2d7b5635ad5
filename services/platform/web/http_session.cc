#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <limits>
#include <optional>

#include "services/platform/web/sessions.h"

namespace intaglio::web {
namespace {

std::string_view ViewOf(beast::string_view text) { return {text.data(), text.size()}; }

Response RefusalOf(const Core& core, int status, const std::string& sentence) {
  if (core.handlers.refusal) return core.handlers.refusal(status, sentence);
  return TextResponse(status, "text/plain; charset=utf-8", sentence + "\n");
}

using Head = http::request_header<>;

/// The only value of a header; empty: there is none. False: there are several.
bool Single(const Head& request, http::field name, std::string_view& value) {
  if (request.count(name) > 1) return false;
  value = ViewOf(request[name]);
  return true;
}

/// Empty: nobody's.
std::string SessionOf(const Core& core, const Head& request) {
  std::string_view cookies, bearer;
  if (!Single(request, http::field::cookie, cookies) ||
      !Single(request, http::field::authorization, bearer))
    return {};
  for (const std::string_view token :
       {CookieIn(cookies, core.CookieName()), BearerKeyIn(bearer)}) {
    if (IsSameKey(token, core.options.key)) return kKeySession;
    if (token.empty() || !core.handlers.session) continue;
    if (auto session = core.handlers.session(std::string(token)); !session.empty())
      return session;
  }
  return {};
}

constexpr char kLogIn[] =
    "log in, or open the address that was printed, with its key, or send "
    "\"Authorization: Bearer KEY\"";

/// Why the request is refused whatever it asks for.
std::optional<Response> WhyForeign(const Core& core, const Head& request) {
  std::string_view host, origin;
  if (!Single(request, http::field::host, host) || !IsOwnHost(host, core.own))
    return RefusalOf(core, 421,
                     fmt::format("this is {}:{}", OriginOf(core.own), core.own.port));
  if (!Single(request, http::field::origin, origin) ||
      (!origin.empty() && !IsOwnOrigin(origin, core.own)))
    return RefusalOf(core, 403, "a page of another origin may not use this console");
  return std::nullopt;
}

class HttpSession : public Waiting, public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(Core& core, Stream stream)
      : counted_(std::make_shared<Counted>(core)),
        core_(core),
        stream_(std::move(stream)),
        answer_timer_(core_.io) {
    ErrorOf ignored;
    const auto end = stream_.tcp().socket().remote_endpoint(ignored);
    if (!ignored) address_ = end.address().to_string();
  }
  ~HttpSession() override { StopWaiting(); }

  void Start() {
    place_ = core_.waiting.insert(core_.waiting.end(), this);
    stream_.expires_after(core_.options.limits.request_time);
    stream_.transport().Open([self = shared_from_this()](ErrorOf error) {
      self->StopWaiting();
      if (error) return self->Close();
      self->Read();
    });
  }
  void Close() override {
    StopWaiting();
    stream_.close();
  }

 private:
  void StopWaiting() {
    if (place_) core_.waiting.erase(*place_);
    place_.reset();
  }

  void Read() {
    const Limits& limits = core_.options.limits;
    place_ = core_.waiting.insert(core_.waiting.end(), this);
    head_.emplace();
    head_->header_limit(static_cast<std::uint32_t>(limits.header_bytes));
    head_->body_limit(std::numeric_limits<std::uint64_t>::max());
    stream_.expires_after(limits.request_time);
    http::async_read_header(stream_, buffer_, *head_,
                            [self = shared_from_this()](ErrorOf error, std::size_t) {
                              if (error) return self->Receive(error);
                              self->ReadBody();
                            });
  }

  void ReadBody() {
    const std::uint64_t limit = core_.options.limits.body_bytes;
    if (IsLong(head_->get())) {
      StopWaiting();
      return DecideLong();
    }
    if (head_->content_length().value_or(0) > limit)
      return Receive(http::error::body_limit);
    parser_.emplace(std::move(*head_));
    parser_->body_limit(limit);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](ErrorOf error, std::size_t) {
                       self->Receive(error);
                     });
  }

  void Receive(ErrorOf error) {
    StopWaiting();
    keep_alive_ = false;
    if (error == http::error::body_limit)
      return Write(Refusal(413, "the body is too large"));
    if (error == http::error::header_limit)
      return Write(Refusal(431, "the headers are too large"));
    if (error == http::error::end_of_stream) return Close();
    if (error &&
        error.category() == http::make_error_code(http::error::bad_method).category())
      return Write(Refusal(400, "this is no HTTP request"));
    if (error) return Close();
    RawRequest request = parser_->release();
    keep_alive_ = request.keep_alive() && request.version() == 11;
    Decide(std::move(request));
  }

  bool IsLong(const Head& head) const {
    const auto target = ParseTarget(ViewOf(head.target()));
    const auto& paths = core_.options.long_paths;
    return target && head.method() == http::verb::post &&
           std::any_of(paths.begin(), paths.end(), [&](const std::string& path) {
             return target->path.starts_with(path);
           });
  }

  /// A request of a long path, before its body.
  void DecideLong() {
    const Head& head = head_->get();
    keep_alive_ = false;
    if (auto foreign = WhyForeign(core_, head)) return Write(*foreign);
    const Caller caller{SessionOf(core_, head), address_};
    if (caller.session.empty()) return Write(Refusal(401, kLogIn));
    if (!head_->content_length())
      return Write(Refusal(411, "give the length of the body (Content-Length)"));
    Request request{"POST", *ParseTarget(ViewOf(head.target())), {}, caller};
    StartLongBody(counted_, std::move(stream_), std::move(buffer_), std::move(*head_),
                  std::move(request));
  }

  void Decide(RawRequest request) {
    if (auto foreign = WhyForeign(core_, request)) return Write(*foreign);
    auto target = ParseTarget(ViewOf(request.target()));
    if (!target) return Write(Refusal(400, target.error().message));
    const bool get = request.method() == http::verb::get;
    if (!get && request.method() != http::verb::post)
      return Write(Refusal(405, "GET and POST alone are known"));
    const auto page = core_.options.pages.find(target->path);
    if (get && page != core_.options.pages.end())
      return WritePage(page->second, target->query);
    const Caller caller{SessionOf(core_, request), address_};
    if (caller.session.empty() && !IsOneOf(core_.options.open_paths, target->path)) {
      return Write(Refusal(401, kLogIn));
    }
    if (get && IsOneOf(core_.options.socket_paths, target->path))
      return StartSocketOf(std::move(request), target->path, caller);
    if (get && IsOneOf(core_.options.event_paths, target->path)) {
      if (!HasRoom()) return;
      stream_.expires_never();
      return StartEvents(counted_, std::move(stream_), target->path, caller);
    }
    Ask({std::string(ViewOf(request.method_string())), std::move(*target),
         std::move(request.body()), caller});
  }

  Response Refusal(int status, const std::string& sentence) const {
    return RefusalOf(core_, status, sentence);
  }

  static bool IsOneOf(const std::vector<std::string>& paths, const std::string& path) {
    return std::find(paths.begin(), paths.end(), path) != paths.end();
  }

  bool HasRoom() {
    if (core_.peers.size() < core_.options.limits.peer_count) return true;
    Write(Refusal(503, "too many pages are open: close some"));
    return false;
  }

  void StartSocketOf(RawRequest request, const std::string& path, const Caller& caller) {
    if (!beast::websocket::is_upgrade(request))
      return Write(Refusal(426, "this path is a WebSocket"));
    if (!HasRoom()) return;
    StartSocket(counted_, std::move(stream_), std::move(request), path, caller);
  }

  void WritePage(const Response& page, const std::map<std::string, std::string>& query) {
    const auto key = query.find("key");
    if (key == query.end() || !IsSameKey(key->second, core_.options.key))
      return Write(page);
    message_ = {};
    message_.set(http::field::location, "/");
    Response redirect = TextResponse(303, "text/plain; charset=utf-8", "");
    redirect.token = core_.options.key;
    WriteMessage(redirect);
  }

  /// The handler may answer from any thread, and late; only the first answer counts.
  void Ask(const Request& request) {
    stream_.expires_never();
    const std::weak_ptr<HttpSession> weak = shared_from_this();
    const std::uint64_t number = ++asked_;
    net::io_context& io = core_.io;
    answer_timer_.expires_after(core_.options.limits.answer_time);
    answer_timer_.async_wait([self = shared_from_this(), number](ErrorOf error) {
      if (!error) self->Answer(number, self->Refusal(504, "no answer in time"));
    });
    core_.handlers.request(request, [weak, number, &io](Response response) {
      net::post(io, [weak, number, response = std::move(response)] {
        if (const auto self = weak.lock()) self->Answer(number, response);
      });
    });
  }

  void Answer(std::uint64_t number, const Response& response) {
    if (number != asked_ || answered_ == number) return;
    answered_ = number;
    answer_timer_.cancel();
    Write(response);
  }

  void Write(const Response& response) {
    message_ = {};
    WriteMessage(response);
  }

  /// `message_` has the headers that this response alone has.
  void WriteMessage(const Response& response) {
    body_ = response.body;
    if (response.token) {
      message_.set(
          http::field::set_cookie,
          fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict{}{}", core_.CookieName(),
                      *response.token, core_.own.is_encrypted ? "; Secure" : "",
                      response.token->empty() ? "; Max-Age=0" : ""));
    }
    if (!response.allow.empty()) message_.set(http::field::allow, response.allow);
    Fill(message_, response, core_, keep_alive_);
    stream_.expires_after(core_.options.limits.write_time);
    http::async_write(stream_, message_,
                      [self = shared_from_this()](ErrorOf error, std::size_t) {
                        if (error || !self->keep_alive_) return self->Close();
                        self->Read();
                      });
  }

  CountedPtr counted_;
  Core& core_;
  Stream stream_;
  std::string address_;  // of the other computer
  net::steady_timer answer_timer_;
  beast::flat_buffer buffer_;
  std::optional<HeadParser> head_;
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::buffer_body> message_;
  std::shared_ptr<const std::string> body_;
  std::optional<std::list<Waiting*>::iterator> place_;
  std::uint64_t asked_ = 0, answered_ = 0;
  bool keep_alive_ = false;
};

}  // namespace

Response TextResponse(int status, std::string content_type, std::string body) {
  return {status, std::move(content_type),
          std::make_shared<const std::string>(std::move(body))};
}

void StartHttp(Core& core, Stream stream) {
  std::make_shared<HttpSession>(core, std::move(stream))->Start();
}

}  // namespace intaglio::web
