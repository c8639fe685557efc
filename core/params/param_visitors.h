// What grows from the one description of every parameter (param_info.h): JSON in and out, JSON
// Schema, access by key. Works on a list of typed references, so that none of it is a template
// beyond list_params().
#pragma once
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "params/param_info.h"

namespace s3 {

using ParamField = std::variant<double*, int*, bool*, std::string*>;

/// One parameter of a live struct: where its value is, and what is known of it.
struct ParamRef {
  ParamField field;
  ParamInfo info;
};

/// Every parameter of one or more structs, in the order of their description. Refers to the
/// structs: they must outlive the list.
class ParamList {
 public:
  template <class T>
  void operator()(T& field, ParamInfo info) {
    params_.push_back({&field, std::move(info)});
  }
  const std::vector<ParamRef>& params() const { return params_; }

  /// The parameter of that key, or nullptr.
  const ParamRef* find(std::string_view key) const;
  /// The known key that looks most like `key`; empty for an empty list.
  std::string_view nearest_key(std::string_view key) const;

 private:
  std::vector<ParamRef> params_;
};

template <class Params>
ParamList list_params(Params& params) {
  ParamList list;
  describe(list, params);
  return list;
}

/// The values as indented JSON, nested at the dots of the keys; ends with a newline.
std::string to_json(const ParamList& list);

/// Sets every parameter that `json` names; the others keep their values.
/// @param json       an object that nests at the dots
/// @param file_name  for messages
/// @throws Error "params.bad_json", "params.unknown_key", "params.wrong_type",
/// "params.out_of_range": names the key, the
///         value and the range, and the nearest known key. Nothing is set unless all of it is
///         right.
void from_json(const ParamList& list, std::string_view json, std::string_view file_name);

/// Sets one parameter from text, as a command line gives it ("0.8", "true", "paper").
/// @throws Error as from_json
void set_by_key(const ParamList& list, std::string_view key, std::string_view text);

/// JSON Schema (2020-12) of all parameters; defaults are the list's present values. Ends with a
/// newline.
std::string json_schema(const ParamList& list);

/// Positions of the parameters that differ between two lists of the same struct.
std::vector<std::size_t> diff(const ParamList& a, const ParamList& b);

/// @throws Error "params.out_of_range" for the first value outside its range or choices
void check_ranges(const ParamList& list);

}  // namespace s3
