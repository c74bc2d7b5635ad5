#pragma once

// What the web server of the console asks the shop for: /api/v1, /metrics and the
// WebSocket /control. docs/console.md describes each path.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "services/console/answers/find_job.h"
#include "services/console/audit_log.h"
#include "services/console/cloud_reader.h"
#include "services/console/console_access.h"
#include "services/console/photo_api.h"
#include "services/console/shop_desk.h"
#include "services/console/submit/submit_api.h"
#include "services/console/teach/jog_desk.h"
#include "services/console/teach/teach_api.h"
#include "services/console/webhooks/webhooks.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

inline constexpr char kEventsPath[] = "/api/v1/events";
inline constexpr char kControlPath[] = "/control";

class Api {
 public:
  /// All live longer.
  Api(ShopDesk& desk, CloudReader& clouds, ConsoleAccess& access, AuditLog& audit,
      WorkQueue& log_ins, SubmitApi& submit, JogDesk& jogs, TeachApi& teach,
      PhotoApi& photos, const Webhooks& webhooks, FindJob find_job,
      std::filesystem::path database)
      : desk_(desk),
        clouds_(clouds),
        access_(access),
        audit_(audit),
        log_ins_(log_ins),
        submit_(submit),
        jogs_(jogs),
        teach_(teach),
        photos_(photos),
        webhooks_(webhooks),
        find_job_(std::move(find_job)),
        database_(std::move(database)) {}

  // In the server's thread.
  void Answer(const web::Request& request, web::Reply reply);
  /// Takes the body of a request below kSubmissionsPath; null: refused.
  std::shared_ptr<web::BodySink> Receive(const web::Request& request,
                                         std::uint64_t body_bytes, web::Reply reply);
  /// The answer to a text from the WebSocket, in one line of JSON.
  std::string AnswerMessage(web::PeerId page, const web::Caller& caller,
                            const std::string& text);

 private:
  /// Who sends it, and may; nullopt: it is refused and answered. POST is audited.
  std::optional<Visitor> Admit(const web::Request& request, web::Reply& reply);
  /// Why it was not passed on; nullopt: it was.
  std::optional<ConsoleError> Jog(web::PeerId page, const web::Caller& caller,
                                  const Visitor& visitor, const JogRequest& request);
  void LogIn(const web::Request& request, const web::Reply& reply);
  void AnswerSession(const std::string& path, const Visitor& visitor,
                     const web::Reply& reply);
  /// The same, which is also written to the audit log.
  web::Reply Audited(const web::Request& request, const Visitor& visitor,
                     web::Reply reply);
  void Dispatch(const web::Request& request, const Visitor& visitor, web::Reply reply);
  void AnswerGet(const std::string& path, const web::Request& request, web::Reply reply);
  void AnswerPost(const std::string& path, const web::Request& request, web::Reply reply);
  void Reset(const std::string& cell, const web::Request& request, const Visitor& visitor,
             web::Reply reply);
  void AnswerJob(const std::string& job, const std::string& part, std::uint32_t from,
                 web::Reply reply);

  ShopDesk& desk_;
  CloudReader& clouds_;
  ConsoleAccess& access_;
  AuditLog& audit_;
  WorkQueue& log_ins_;  // where passwords are checked
  SubmitApi& submit_;
  JogDesk& jogs_;
  TeachApi& teach_;
  PhotoApi& photos_;
  const Webhooks& webhooks_;
  FindJob find_job_;
  std::filesystem::path database_;  // of the job service; empty: not known
};

/// What a page asks for on the WebSocket. kInvalidValue: it is no ConsoleRequest.
Result<ConsoleRequest> ParseConsoleRequest(const std::string& text);

}  // namespace intaglio::console
