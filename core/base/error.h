// What goes wrong, as one type: a stable code, a sentence for a person, a hint that helps them go
// on.
#pragma once
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/stage.h"
#include "base/types.h"

namespace s3 {

enum class ErrorKind {
  input,   // the user's file, parameter or machine is wrong (exit code 2)
  slicing  // the pipeline could not finish a valid input (exit code 3)
};

/// Thrown by every stage. `code` is stable text such as "mesh.open_boundary": first the stage, then
/// the case.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, Stage stage, std::string code, const std::string& message,
        std::string hint = {}, std::vector<Vec3> where = {})
      : std::runtime_error(message),
        kind(kind),
        stage(stage),
        code(std::move(code)),
        hint(std::move(hint)),
        where(std::move(where)) {}

  ErrorKind kind;
  Stage stage;
  std::string code;
  std::string hint;         // what to do about it
  std::vector<Vec3> where;  // places in the model, mm, for the views to highlight
};

/// Thrown by Context::checkpoint() after a cancel. Not an Error: nothing went wrong.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

/// A result that is usable but doubtful; kept with the stage and written to the report.
struct Warning {
  std::string code;
  std::string message;
  std::vector<Vec3> where;  // mm
};

}  // namespace s3
