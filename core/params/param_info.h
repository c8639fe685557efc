// One description of every parameter. Each stage owns a plain struct of parameters with defaults
// and a function
//   template <class Visitor> void describe(Visitor& v, XParams& p) { v(p.field, {.key = …, …}); }
// beside it; JSON, CLI, schema and forms grow from these (params/param_visitors.h).
#pragma once
#include <limits>
#include <string_view>
#include <vector>

#include "base/stage.h"

namespace s3 {

struct ParamInfo {
  std::string_view key;    // "deform.rigidity": JSON nests at the dots
  std::string_view label;  // "Rigidity"
  std::string_view unit;   // "mm", "deg", "" …
  std::string_view doc;    // one sentence
  double min = -std::numeric_limits<double>::infinity();  // inclusive, numbers only
  double max = std::numeric_limits<double>::infinity();
  std::vector<std::string_view> choices =
      {};                     // strings only: the allowed values, empty for free text
  Stage stage = Stage::mesh;  // the earliest stage that a change makes stale
  bool advanced = false;
};

}  // namespace s3
