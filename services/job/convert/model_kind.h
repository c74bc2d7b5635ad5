#pragma once

// What a model is, by its file's ending, and which files a job is made from.

#include <functional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "services/job/methods/method.h"

namespace intaglio {

/// Whether the model is a text. That of a model with a file and no letters of its own
/// only has the font of the texts in its drawing.
bool IsText(const Model& model);

/// Whether it is made from a file, which may be missing: no text, no code, no points.
bool HasFile(const Model& model);

/// "a mesh", "a drawing", ...
const char* NameOf(ModelKind kind);

/// By the file's ending; kUnsupported lists the endings that are known. A PLY counts as a
/// mesh; only its reader can determine whether it has faces.
Result<ModelKind> KindOfFile(const std::string& file);

/// The same of a model: a text, a code and points given one by one are of no file.
Result<ModelKind> KindOf(const Model& model);

/// Whether its file may declare the length of its unit, as 3MF, DAE and DXF do, or its
/// format defines it, as SVG and HPGL do: a unit of the job replaces that one, and has no
/// default.
bool MayDeclareUnit(const Model& model);

/// Whether points of such a model can be made by that method.
bool Suits(Model::MethodCase method, ModelKind kind);

/// Calls visit(file, field) for every file name of the job but the machine's, `field`
/// as in "models[0].relief.photo". Those that are optional and not there are left out.
void ForEachFile(JobSpec& job,
                 const std::function<void(std::string&, const std::string&)>& visit);

/// The files that the models of a job with its defaults filled in are made from, in the
/// order in which they are sent and taken (model_sources.h).
std::vector<std::string> FilesOf(const JobSpec& job);

}  // namespace intaglio
