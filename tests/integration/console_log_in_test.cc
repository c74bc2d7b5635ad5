// Who is logged in to a console, and what each may do: OWASP's list, by a shop of real
// processes (https://owasp.org/www-project-web-security-testing-guide, sections 4.4 to
// 4.7).

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "services/console/routes.h"
#include "tests/integration/console_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using namespace intaglio::testing;
using console::Right;
using console::Route;
using test::Ask;
using test::WebAnswer;
using test::WebConnection;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kAnnasPassword[] = "correct horse";
constexpr char kBertsPassword[] = "battery staple";

/// The path of a route, with 1 for each part that it leaves open.
std::string PathOf(const Route& route) {
  return std::regex_replace(std::string(route.path), std::regex("\\{[a-z]+\\}"), "1");
}

class ConsoleLogIn : public ConsoleShop {
 protected:
  /// By the command that docs/console.md names.
  void AddUser(const std::string& name, const std::string& role,
               const std::string& password) const {
    const std::string command = fmt::format(
        "printf '%s\\n' '{}' | {} console user add {} --role {} --users {} > /dev/null",
        password, Program("intaglio").string(), name, role, users_file_.string());
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  WebAnswer TryLogIn(const std::string& name, const std::string& password,
                     const std::string& headers = {}) const {
    return Ask(port_, {.method = "POST",
                       .path = "/api/v1/login",
                       .body = fmt::format(R"({{"name": "{}", "password": "{}"}})", name,
                                           password),
                       .headers = headers});
  }
  /// The header with the cookie of a new session.
  std::string LogIn(const std::string& name, const std::string& password) const {
    const WebAnswer answer = TryLogIn(name, password);
    EXPECT_EQ(answer.status, 200) << answer.body;
    std::smatch cookie;
    EXPECT_TRUE(std::regex_search(
        answer.headers, cookie,
        std::regex("Set-Cookie: (intaglio_[0-9]+=[0-9a-f]{64}); Path=/; HttpOnly; "
                   "SameSite=Strict\r\n")))
        << answer.headers;
    return "Cookie: " + cookie[1].str() + "\r\n";
  }
  WebAnswer Send(const std::string& method, const std::string& path,
                 const std::string& headers, const std::string& body = "{}") const {
    return Ask(port_, {.method = method, .path = path, .body = body, .headers = headers});
  }
  /// Opens /control and reads its first state; empty: it is refused.
  std::string FirstState(const std::string& headers) const {
    WebConnection control(port_);
    control.Send(test::Upgrade(port_, "/control", "", headers));
    if (control.ReadUntil("\r\n\r\n", 10s).find(" 101 ") == std::string::npos) return {};
    return test::ReadFrame(control, 10s).value_or("");
  }
  std::string Audit() const {
    std::ifstream in(audit_file_);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

TEST_F(ConsoleLogIn, WithoutASessionNothingIsAnsweredButTheLogIn) {
  Open();
  AddUser("anna", "operator", kAnnasPassword);
  for (const Route& route : console::Routes()) {
    const std::string forged =
        "Cookie: intaglio_" + std::to_string(port_) + "=" + std::string(64, 'a') + "\r\n";
    for (const std::string& headers : {std::string(), forged}) {
      const WebAnswer answer = Send(std::string(route.method), PathOf(route), headers);
      EXPECT_EQ(answer.status, 401) << route.path;
    }
  }
  EXPECT_EQ(FirstState(""), "");
  EXPECT_EQ(TryLogIn("anna", "wrong password").status, 401);
  EXPECT_EQ(TryLogIn("nobody", kAnnasPassword).body, TryLogIn("anna", "wrong").body);
  EXPECT_THAT(TryLogIn("nobody", "x").headers, Not(HasSubstr("Cookie")));
  const std::string foreign = "Origin: https://evil.example\r\n";
  EXPECT_EQ(TryLogIn("anna", kAnnasPassword, foreign).status, 403);
  EXPECT_EQ(TryLogIn("anna", kAnnasPassword).status, 200);
}

TEST_F(ConsoleLogIn, AnObserverMayReadAndStopAndNothingElse) {
  Open();
  AddUser("bert", "observer", kBertsPassword);
  const std::string bert = LogIn("bert", kBertsPassword);
  EXPECT_THAT(Send("GET", "/api/v1/session", bert).body, HasSubstr("\"observer\""));
  for (const Route& route : console::Routes()) {
    if (route.right == Right::kOpen || route.path.ends_with("logout") ||
        route.path.ends_with("events"))
      continue;
    const WebAnswer answer = Send(std::string(route.method), PathOf(route), bert);
    if (route.right == Right::kRead)
      EXPECT_THAT(answer.status, ::testing::AnyOf(200, 404)) << route.path;
    else
      EXPECT_EQ(answer.status, 403) << route.path << answer.body;
  }
  EXPECT_THAT(FirstState(bert), HasSubstr("\"shop\""));
  EXPECT_EQ(FirstState(bert + "Origin: https://evil.example\r\n"), "");
  EXPECT_EQ(Send("POST", "/api/v1/stop", bert + "Origin: null\r\n").status, 403);
  const WebAnswer stopped = Send("POST", "/api/v1/stop", bert);
  EXPECT_EQ(stopped.status, 200);
  EXPECT_THAT(stopped.body, HasSubstr("\"sent\": true"));
  EXPECT_THAT(Send("GET", "/api/v1/session", bert).body,
              HasSubstr("\"in_charge\": \"\""));
}

TEST_F(ConsoleLogIn, ASessionEndsWithItsOpenPages) {
  Open();
  AddUser("anna", "operator", kAnnasPassword);
  const std::string anna = LogIn("anna", kAnnasPassword);
  const std::string other = LogIn("anna", kAnnasPassword);
  WebConnection control(port_);
  control.Send(test::Upgrade(port_, "/control", "", anna));
  ASSERT_THAT(control.ReadUntil("\r\n\r\n", 10s), HasSubstr(" 101 "));
  const WebAnswer left = Send("POST", "/api/v1/logout", anna);
  EXPECT_EQ(left.status, 200);
  EXPECT_THAT(left.headers, HasSubstr("Max-Age=0"));
  EXPECT_TRUE(control.Ends(10s));
  EXPECT_EQ(Send("GET", "/api/v1/status", anna).status, 401);
  EXPECT_EQ(FirstState(anna), "");
  EXPECT_EQ(Send("GET", "/api/v1/status", other).status, 200);
  // Who is removed is out at once.
  const std::string command =
      fmt::format("{} console user remove anna --users {}", Program("intaglio").string(),
                  users_file_.string());
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_TRUE(Eventually(
      [&] { return Send("GET", "/api/v1/status", other).status == 401; }, 10s));
}

TEST_F(ConsoleLogIn, TenWrongPasswordsSlowDown) {
  Open();
  AddUser("anna", "operator", kAnnasPassword);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(TryLogIn("anna", "wrong password").status, 401);
  const WebAnswer late = TryLogIn("anna", kAnnasPassword);
  EXPECT_EQ(late.status, 429);
  EXPECT_THAT(late.body, HasSubstr("wait"));
  EXPECT_TRUE(
      Eventually([&] { return TryLogIn("anna", kAnnasPassword).status == 200; }, 10s));
}

TEST_F(ConsoleLogIn, OnePersonIsInChargeAndEverybodySeesWho) {
  AwaitArm();
  AddUser("anna", "operator", kAnnasPassword);
  AddUser("bert", "operator", kBertsPassword);
  const std::string anna = LogIn("anna", kAnnasPassword);
  const std::string bert = LogIn("bert", kBertsPassword);
  const std::string job = "/api/v1/jobs/" + *job_;
  const std::string block = fmt::format(R"({{"block": "{}"}})", block_);
  const auto hold = [&](const std::string& who) {
    const WebAnswer held = Send("POST", job + "/hold", who, block);
    std::smatch token;
    return std::regex_search(held.body, token,
                             std::regex("\"token\": \"([0-9a-f]{64})\""))
               ? fmt::format(R"({{"token": "{}"}})", token[1].str())
               : held.body;
  };
  const std::string held = hold(anna);
  EXPECT_THAT(held, HasSubstr("token"));
  EXPECT_THAT(hold(bert), HasSubstr("anna is in charge"));
  EXPECT_EQ(Send("POST", job + "/cancel", bert).status, 409);
  EXPECT_EQ(PostToJob("cancel").status, 409) << "the key is one more person";
  EXPECT_EQ(Send("POST", "/api/v1/charge", bert).status, 200);
  std::this_thread::sleep_for(1300ms);
  ExpectRefused(Send("POST", job + "/arm", anna, held), "not_in_charge");
  ExpectRefused(Send("POST", job + "/arm", bert, held), "not_held");
  EXPECT_THAT(FirstState(anna), HasSubstr("\"in_charge\":\"bert\""));
  ExpectNothingFires();
  EXPECT_EQ(floor_.Panel("cracks"), 0);
  const std::string again = hold(bert);
  std::this_thread::sleep_for(1300ms);
  EXPECT_EQ(Send("POST", job + "/arm", bert, again).status, 200);
  ASSERT_TRUE(floor_.AwaitCracks(5, 40s)) << floor_.Logs();
  EXPECT_EQ(Send("POST", job + "/pause", anna).status, 200) << "any operator may pause";
  Send("POST", "/api/v1/logout", bert);
  EXPECT_TRUE(Eventually(
      [&] { return FirstState(anna).find("\"in_charge\":\"\"") != std::string::npos; },
      10s));
  EXPECT_TRUE(Eventually(
      [&] { return Audit().find("/api/v1/logout") != std::string::npos; }, 10s));
  const std::string audit = Audit();
  EXPECT_THAT(audit, HasSubstr(R"("name":"bert","role":"operator","address":"127.0.0.1",)"
                               R"("request":"POST )" +
                               job + R"(/arm","status":200})"));
  EXPECT_THAT(audit, HasSubstr(R"("request":"POST )" + job + R"(/arm","status":409})"));
  EXPECT_THAT(audit, HasSubstr(R"("request":"POST /api/v1/login","status":200})"));
  EXPECT_THAT(audit, Not(HasSubstr("horse")));
  EXPECT_THAT(audit, Not(HasSubstr("token")));
}

}  // namespace
}  // namespace intaglio
