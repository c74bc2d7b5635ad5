// A terminal reports a key that is held as the same key again and again: 250 to 660 ms
// after the first, then every 20 to 40 ms. So a first press is a step, and a repetition
// is continuous motion, which ends kKeyTime after the last repetition. A terminal that
// hangs, a connection that is lost and a program that is stopped repeat nothing: the
// bridge notices the silence within 200 ms.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <optional>
#include <string>
#include <utility>

#include "services/cli/teach/teach_options.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {
namespace {

using Clock = std::chrono::steady_clock;
using client::TeachClient;
using client::TeachOrder;
using namespace std::chrono_literals;

constexpr auto kKeyTime = 120ms;       // longer than any terminal's repetition
constexpr auto kFirstKeyTime = 700ms;  // until the first repetition
constexpr auto kDrawPeriod = 100ms;
constexpr double kSteps[] = {0.01, 0.1, 1, 10};

/// The terminal gives keys one by one and does not show them, until this ends.
class RawTerminal {
 public:
  RawTerminal() {
    valid_ = tcgetattr(STDIN_FILENO, &before_) == 0;
    if (!valid_) return;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    raw.c_cc[VMIN] = 0;
    raw.c_cc[VTIME] = 0;
    tcsetattr(STDIN_FILENO, TCSAFLUSH, &raw);
    std::cout << "\x1b[?25l";
  }
  ~RawTerminal() {
    if (!valid_) return;
    tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
    std::cout << "\x1b[?25h" << std::flush;
  }
  RawTerminal(const RawTerminal&) = delete;
  RawTerminal& operator=(const RawTerminal&) = delete;
  bool valid() const { return valid_; }

 private:
  termios before_{};
  bool valid_ = false;
};

/// Which way a key moves; nullopt: it moves nothing.
std::optional<Vec3> DirectionOf(const std::string& key) {
  if (key == "\x1b[C") return Vec3(1, 0, 0);
  if (key == "\x1b[D") return Vec3(-1, 0, 0);
  if (key == "\x1b[A") return Vec3(0, 1, 0);
  if (key == "\x1b[B") return Vec3(0, -1, 0);
  if (key == "\x1b[5~" || key == "+") return Vec3(0, 0, 1);
  if (key == "\x1b[6~" || key == "-") return Vec3(0, 0, -1);
  return std::nullopt;
}

class TeachScreen {
 public:
  explicit TeachScreen(TeachClient& client) : client_(client) {}

  int Run() {
    while (Interrupts() == 0 && !ends_) {
      client_.Poll();
      if (const std::string key = ReadKey(); !key.empty()) Receive(key);
      Settle();
      Draw();
    }
    client_.LetGo();
    std::cout << "\n";
    return client::kExitGood;
  }

 private:
  /// One key, of which an arrow is three or four bytes; empty: none within 10 ms.
  std::string ReadKey() {
    pollfd in{STDIN_FILENO, POLLIN, 0};
    if (poll(&in, 1, 10) <= 0) return "";
    char bytes[8];
    const ssize_t count = read(STDIN_FILENO, bytes, sizeof bytes);
    if (count <= 0) {
      ends_ = true;  // the terminal is gone
      return "";
    }
    const std::string all(bytes, static_cast<std::size_t>(count));
    // When several were held back, only the last counts.
    const auto escape = all.rfind('\x1b');
    return escape == std::string::npos ? all.substr(all.size() - 1) : all.substr(escape);
  }

  void Receive(const std::string& key) {
    const auto direction = DirectionOf(key);
    if (direction && !asks_home_) return Move(key, *direction);
    client_.LetGo();
    moving_key_.clear();
    if (std::exchange(asks_home_, false)) {
      message_.clear();
      if (key == "y") Start({.kind = intaglio_MANUAL_HOME});
      return;
    }
    if (key == "q") ends_ = true;
    if (key >= "1" && key <= "4") step_ = static_cast<std::size_t>(key[0] - '1');
    if (key == "h") {
      asks_home_ = true;
      message_ = "home, is the way free? y, any other key: no";
    }
    if (key == "s") Start({.kind = intaglio_TEACH_SAMPLE});
    if (key == "p") Start({.kind = intaglio_TEACH_PARK});
    if (key == "u") Start({.kind = intaglio_TEACH_UNDO});
  }

  void Start(const TeachOrder& order) {
    number_ = client_.Hold(order);
    moving_key_.clear();
  }

  void Move(const std::string& key, const Vec3& direction) {
    const auto now = Clock::now();
    const bool repeated = key == moving_key_ && now < key_ends_;
    key_ends_ = now + (repeated ? kKeyTime : kFirstKeyTime);
    if (repeated && continuous_) return;
    moving_key_ = key;
    continuous_ = repeated;
    TeachOrder order;
    order.speed_mm_s = std::max(0.1, 10 * kSteps[step_]);
    order.kind = repeated ? intaglio_MANUAL_JOG : intaglio_MANUAL_MOVE;
    order.place =
        repeated ? direction : client_.view().position + kSteps[step_] * direction;
    number_ = client_.Hold(order);
  }

  /// A key that is not repeated any more is let go.
  void Settle() {
    if (number_ != 0 && client_.IsAnswered(number_)) {
      message_ = client_.view().message;
      number_ = 0;
      client_.LetGo();
    }
    if (continuous_ && !moving_key_.empty() && Clock::now() > key_ends_) {
      client_.LetGo();
      moving_key_.clear();
    }
  }

  void Draw() {
    const auto now = Clock::now();
    if (now < next_draw_) return;
    next_draw_ = now + kDrawPeriod;
    std::string text =
        TextOf(client_.view()) +
        fmt::format(
            "\n  step {:g} (mm, of a rotary axis rad)   {}\n\n"
            "  arrows x and y, page up and down z: a step, held: continuous\n"
            "  1 2 3 4 step {:g}   h home   s sample   p park   u undo   q end\n"
            "  zeros: `intaglio teach zero`, what is mounted: `intaglio teach mount`, in "
            "another terminal\n",
            kSteps[step_], message_, fmt::join(kSteps, " "));
    // Each line is written over the one before and cleared behind it: nothing flickers.
    for (std::size_t at = text.find('\n'); at != std::string::npos;
         at = text.find('\n', at + 4)) {
      text.insert(at, "\x1b[K");
    }
    std::cout << "\x1b[H" << text << "\x1b[J" << std::flush;
  }

  TeachClient& client_;
  bool ends_ = false, continuous_ = false, asks_home_ = false;
  std::size_t step_ = 1;
  std::string moving_key_, message_;
  std::uint64_t number_ = 0;
  Clock::time_point key_ends_, next_draw_;
};

}  // namespace

int ShowTeachScreen(TeachClient& client) {
  const RawTerminal terminal;
  if (!terminal.valid()) {
    return Complain({ErrorCode::kUnsupported,
                     "the screen needs a terminal: use the commands below `intaglio "
                     "teach`, see `intaglio help teach`",
                     ""});
  }
  return TeachScreen(client).Run();
}

}  // namespace intaglio::cli
