#pragma once

// The requests below /api/v1/submissions: files of a job, then its job file.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/console/answers/work_queue.h"
#include "services/console/submit/submissions.h"
#include "services/console/submit/upload_folder.h"
#include "services/platform/web/server.h"

namespace intaglio::console {

inline constexpr char kSubmissionsPath[] = "/api/v1/submissions/";

/// "order-7" and "knot.stl" of "/api/v1/submissions/order-7/files/knot.stl", whose file
/// is empty in "/api/v1/submissions/order-7". nullopt: another path.
struct SubmissionPath {
  std::string id, file;
  bool is_preview = false;  ///< "/api/v1/submissions/order-7/preview"
};
std::optional<SubmissionPath> ParseSubmissionPath(std::string_view path);

struct SubmitOptions {
  std::filesystem::path uploads;            ///< folder; empty: nothing is submitted here
  std::vector<std::string> shop_arguments;  ///< by which `intaglio` finds the shop
  std::string materials;  ///< material base of previews; empty: the user's
  ShopMachines machines;  ///< those whose profiles a job may name
};

/// In the server's thread; disks and processes have threads of their own.
class SubmitApi {
 public:
  explicit SubmitApi(const SubmitOptions& options)
      : materials_(options.materials),
        machines_(options.machines),
        uploads_(options.uploads),
        submissions_(uploads_, options.shop_arguments, options.materials,
                     options.machines) {}

  /// How much of a file has come, or the picture of a preview.
  void AnswerGet(const SubmissionPath& path, web::Reply reply);
  /// JobChoices.
  void AnswerChoices(web::Reply reply);
  /// A job file, or the bytes of another one, from `offset` of the query on; `size` is
  /// where that ends, default the end of this body.
  std::shared_ptr<web::BodySink> Receive(const SubmissionPath& path,
                                         const web::Request& request,
                                         std::uint64_t body_bytes, web::Reply reply);
  /// Submissions::SubmitWritten.
  void SubmitWritten(const std::string& id, Submissions::Writer writer, web::Reply reply);

 private:
  class JobFileSink;
  void Submit(const std::string& id, std::string job_file, web::Reply reply);
  void Run(std::function<SubmissionAnswer()> submit, const web::Reply& reply);
  void Preview(const std::string& id, std::string job_file, web::Reply reply);

  std::string materials_;
  ShopMachines machines_;
  UploadFolder uploads_;
  Submissions submissions_;
  WorkQueue disk_{64};
  WorkQueue runs_{16};
  WorkQueue previews_{4};
};

}  // namespace intaglio::console
