#include "services/platform/access/log_ins.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>

#include "engrave/core/try.h"
#include "services/platform/access/new_key.h"

namespace intaglio::access {
namespace {

// A flood of names does not fill the memory.
constexpr std::size_t kMaxFailureKeys = 1000;
constexpr int kMaxDoublings = 20;

/// What is compared and kept of a token: who reads the memory or measures the time of a
/// search learns no token.
std::string IdOf(const std::string& token) {
  std::array<unsigned char, crypto_generichash_BYTES> hash{};
  crypto_generichash(hash.data(), hash.size(),
                     reinterpret_cast<const unsigned char*>(token.data()), token.size(),
                     nullptr, 0);
  std::string id;
  for (const unsigned char byte : hash) id += fmt::format("{:02x}", byte);
  return id;
}

/// Checked when there is no such user, so that the time of an answer names none.
const std::string& HashOfNobody() {
  static const std::string hash = HashOf(NewKey());
  return hash;
}

const User* FindUser(const std::vector<User>& users, const std::string& name) {
  const auto found = std::find_if(users.begin(), users.end(),
                                  [&](const User& user) { return user.name == name; });
  return found == users.end() ? nullptr : &*found;
}

}  // namespace

LogIns::LogIns(std::filesystem::path users_file, LogInLimits limits)
    : users_file_(std::move(users_file)), limits_(limits) {}

Result<LogIns::Opened> LogIns::LogIn(const std::string& name, const std::string& password,
                                     const std::string& address, Clock::time_point now) {
  const std::string keys[] = {"name " + name.substr(0, kMaxNameBytes),
                              "address " + address};
  {
    const std::lock_guard lock(mutex_);
    for (const std::string& key : keys) {
      const auto wait = WaitOf(key, now);
      if (wait == std::chrono::seconds::zero()) continue;
      return Fail(ErrorCode::kTimedOut,
                  fmt::format("too many wrong passwords: wait {} s, then try again",
                              wait.count()));
    }
  }
  auto read = ReadUsers(users_file_);
  if (!read && read.error().code == ErrorCode::kRefused)
    read.error().code = ErrorCode::kIo;  // no wrong password
  const auto users = INTAGLIO_TRY(read);
  const User* user = FindUser(users, name);
  const bool is_right = Matches(user == nullptr ? HashOfNobody() : user->hash,
                                password.substr(0, kMaxPasswordBytes + 1));
  const std::lock_guard lock(mutex_);
  if (user == nullptr || !is_right) {
    for (const std::string& key : keys) CountFailure(key, now);
    return Fail(ErrorCode::kRefused, "name or password is wrong");
  }
  failures_.erase(keys[0]);
  return Start(*user, now);
}

LogIns::Opened LogIns::Start(const User& user, Clock::time_point now) {
  if (sessions_.size() >= limits_.session_count) {
    End(std::min_element(sessions_.begin(), sessions_.end(),
                         [](const auto& one, const auto& other) {
                           return one.second.used < other.second.used;
                         }));
  }
  Opened opened;
  opened.token = NewKey();
  opened.session = {IdOf(opened.token), user.name, user.role};
  sessions_[opened.session.id] = {opened.session, user.hash, now, now, now};
  return opened;
}

std::optional<Session> LogIns::Find(const std::string& token, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(IdOf(token));
  if (found == sessions_.end()) return std::nullopt;
  if (now > found->second.used + limits_.idle_time ||
      now > found->second.opened + limits_.whole_time) {
    End(found);
    return std::nullopt;
  }
  found->second.used = now;
  return SessionOf(found->second, now);
}

Session LogIns::SessionOf(const Open& open, Clock::time_point now) const {
  Session session = open.session;
  session.rests =
      session.role == UserRole::kOperator && now > open.acted + limits_.idle_time;
  if (session.rests) session.role = UserRole::kObserver;
  return session;
}

std::optional<Session> LogIns::At(const std::string& id, Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(id);
  if (found == sessions_.end()) return std::nullopt;
  return SessionOf(found->second, now);
}

void LogIns::Act(const std::string& id, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(id);
  if (found != sessions_.end() && !SessionOf(found->second, now).rests)
    found->second.acted = now;
}

void LogIns::LogOut(const std::string& id) {
  const std::lock_guard lock(mutex_);
  if (const auto found = sessions_.find(id); found != sessions_.end()) End(found);
}

bool LogIns::IsHere(const std::string& name, Clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  return std::any_of(sessions_.begin(), sessions_.end(), [&](const auto& open) {
    return open.second.session.name == name && !SessionOf(open.second, now).rests;
  });
}

std::vector<std::string> LogIns::TakeEnded(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  for (auto open = sessions_.begin(); open != sessions_.end();) {
    const auto next = std::next(open);
    if (now > open->second.used + limits_.idle_time ||
        now > open->second.opened + limits_.whole_time)
      End(open);
    open = next;
  }
  std::error_code error;
  const auto written = std::filesystem::last_write_time(users_file_, error);
  if (!sessions_.empty() && (error || written != users_read_)) {
    const auto users = ReadUsers(users_file_);
    EndBy(users ? *users : std::vector<User>());
    users_read_ = written;
  }
  return std::exchange(ended_, {});
}

void LogIns::EndBy(const std::vector<User>& users) {
  for (auto open = sessions_.begin(); open != sessions_.end();) {
    const auto next = std::next(open);
    const User* user = FindUser(users, open->second.session.name);
    if (user == nullptr || user->role != open->second.session.role ||
        user->hash != open->second.hash)
      End(open);
    open = next;
  }
}

void LogIns::End(std::map<std::string, Open>::iterator session) {
  ended_.push_back(session->first);
  sessions_.erase(session);
}

void LogIns::CountFailure(const std::string& key, Clock::time_point now) {
  std::erase_if(failures_, [&](const auto& failures) {
    return now > failures.second.last + limits_.forget_time;
  });
  if (failures_.size() >= kMaxFailureKeys && !failures_.contains(key)) {
    failures_.erase(std::min_element(failures_.begin(), failures_.end(),
                                     [](const auto& one, const auto& other) {
                                       return one.second.last < other.second.last;
                                     }));
  }
  Failures& failures = failures_[key];
  failures.last = failures.next = now;
  if (++failures.count < limits_.free_failures) return;
  const int doublings = std::min(failures.count - limits_.free_failures, kMaxDoublings);
  failures.next += std::min<std::chrono::seconds>(std::chrono::seconds(1 << doublings),
                                                  limits_.max_wait);
}

std::chrono::seconds LogIns::WaitOf(const std::string& key, Clock::time_point now) const {
  const auto found = failures_.find(key);
  if (found == failures_.end() || now >= found->second.next)
    return std::chrono::seconds::zero();
  return std::chrono::ceil<std::chrono::seconds>(found->second.next - now);
}

}  // namespace intaglio::access
