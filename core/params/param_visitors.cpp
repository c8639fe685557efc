#include "params/param_visitors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <sstream>

#include <nlohmann/json.hpp>

#include "base/error.h"

namespace s3 {
namespace {

using Json = nlohmann::ordered_json;
using Value = std::variant<double, int, bool, std::string>;

// A path given on the command line may hold any bytes: what is no UTF-8 must not make dump() throw.
std::string dump(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// The shortest text of a number; whole numbers without a point.
std::string number_text(double value) {
  std::string text = dump(value);
  if (text.size() > 2 && text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

std::string value_text(const Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  return std::visit([](const auto& v) { return dump(v); }, value);
}

Value current_value(const ParamRef& param) {
  return std::visit([](const auto* field) { return Value(*field); }, param.field);
}

std::string range_text(const ParamInfo& info) {
  std::string unit(info.unit.empty() ? "" : " ");
  unit += info.unit;
  if (std::isinf(info.min) && std::isinf(info.max)) return "any number";
  if (std::isinf(info.max)) return "at least " + number_text(info.min) + unit;
  if (std::isinf(info.min)) return "at most " + number_text(info.max) + unit;
  return number_text(info.min) + " to " + number_text(info.max) + unit;
}

std::string choices_text(const ParamInfo& info) {
  std::string text;
  for (const std::string_view choice : info.choices) {
    if (!text.empty()) text += ", ";
    text += choice;
  }
  return text;
}

[[noreturn]] void fail(Stage stage, const char* code, const std::string& message,
                       const std::string& hint) {
  throw Error(ErrorKind::input, stage, code, message, hint);
}

void check_range(const ParamInfo& info, const Value& value) {
  const auto check_number = [&](double number) {
    if (number >= info.min && number <= info.max) return;  // false for NaN
    fail(info.stage, "params.out_of_range",
         std::string(info.key) + " is " + value_text(value) + ", outside its range",
         "allowed: " + range_text(info));
  };
  if (const auto* number = std::get_if<double>(&value)) check_number(*number);
  if (const auto* number = std::get_if<int>(&value)) check_number(*number);
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr || info.choices.empty()) return;
  if (std::find(info.choices.begin(), info.choices.end(), *text) == info.choices.end())
    fail(info.stage, "params.out_of_range",
         std::string(info.key) + " is " + value_text(value) + ", which is none of its values",
         "allowed: " + choices_text(info));
}

const char* type_name(const ParamField& field) {
  constexpr const char* kNames[] = {"a number", "a whole number", "true or false", "a text"};
  return kNames[field.index()];
}

std::optional<int> whole_number(double number) {
  if (!(std::abs(number) < 2147483647.0) || number != std::floor(number)) return std::nullopt;
  return static_cast<int>(number);
}

/// The value as the field's type, or nothing where the types do not agree.
std::optional<Value> typed_value(const ParamField& field, const Json& json) {
  if (std::holds_alternative<std::string*>(field))
    return json.is_string() ? std::optional<Value>(json.get<std::string>()) : std::nullopt;
  if (std::holds_alternative<bool*>(field))
    return json.is_boolean() ? std::optional<Value>(json.get<bool>()) : std::nullopt;
  if (!json.is_number()) return std::nullopt;
  const double number = json.get<double>();
  if (std::holds_alternative<double*>(field)) return Value(number);
  const auto whole = whole_number(number);
  return whole ? std::optional<Value>(*whole) : std::nullopt;
}

/// The same from the text of a command line.
std::optional<Value> typed_value(const ParamField& field, const std::string& text) {
  if (std::holds_alternative<std::string*>(field)) return Value(text);
  if (std::holds_alternative<bool*>(field)) {
    if (text == "true" || text == "1" || text == "on") return Value(true);
    if (text == "false" || text == "0" || text == "off") return Value(false);
    return std::nullopt;
  }
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (text.empty() || end != text.c_str() + text.size() || !std::isfinite(number))
    return std::nullopt;
  if (std::holds_alternative<double*>(field)) return Value(number);
  const auto whole = whole_number(number);
  return whole ? std::optional<Value>(*whole) : std::nullopt;
}

void assign(const ParamField& field, const Value& value) {
  std::visit(
      [&](auto* target) { *target = std::get<std::remove_pointer_t<decltype(target)>>(value); },
      field);
}

const ParamRef& find_or_fail(const ParamList& list, const std::string& key,
                             const std::string& where) {
  if (const ParamRef* param = list.find(key)) return *param;
  fail(Stage::mesh, "params.unknown_key", where + "there is no parameter \"" + key + "\"",
       "did you mean \"" + std::string(list.nearest_key(key)) +
           "\"? `s3slice schema` lists all parameters");
}

struct Assignment {
  const ParamRef* param;
  Value value;
};

Assignment checked_assignment(const ParamRef& param, const std::optional<Value>& value,
                              const std::string& given, const std::string& where) {
  if (!value)
    fail(param.info.stage, "params.wrong_type",
         where + std::string(param.info.key) + " must be " + type_name(param.field) + ", not " +
             given,
         std::holds_alternative<std::string*>(param.field) ? ""
                                                           : "allowed: " + range_text(param.info));
  check_range(param.info, *value);
  return {&param, *value};
}

void collect(const ParamList& list, const Json& json, const std::string& prefix,
             const std::string& where, std::vector<Assignment>& out) {
  for (const auto& [name, value] : json.items()) {
    const std::string key = prefix.empty() ? name : prefix + "." + name;
    const bool is_group =
        std::any_of(list.params().begin(), list.params().end(), [&](const ParamRef& param) {
          return param.info.key.substr(0, key.size() + 1) == key + ".";
        });
    if (value.is_object() && is_group) {
      collect(list, value, key, where, out);
      continue;
    }
    const ParamRef& param = find_or_fail(list, key, where);
    out.push_back(checked_assignment(param, typed_value(param.field, value), dump(value), where));
  }
}

/// The place in a nested object that a dotted key names.
Json& nested(Json& root, std::string_view key, const char* between = nullptr) {
  Json* node = &root;
  for (std::size_t begin = 0;;) {
    const std::size_t dot = key.find('.', begin);
    const std::string part(key.substr(begin, dot - begin));
    node = between == nullptr ? &(*node)[part] : &(*node)[between][part];
    if (dot == std::string_view::npos) return *node;
    if (between != nullptr && node->is_null())
      *node = {{"type", "object"}, {"additionalProperties", false}};
    begin = dot + 1;
  }
}

/// Levenshtein's distance.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, replaced});
    }
  }
  return row.back();
}

std::string_view last_part(std::string_view key) {
  return key.substr(key.rfind('.') + 1);
}

Json schema_of(const ParamRef& param) {
  const ParamInfo& info = param.info;
  constexpr const char* kTypes[] = {"number", "integer", "boolean", "string"};
  Json schema = {{"key", info.key},
                 {"title", info.label},
                 {"type", kTypes[param.field.index()]},
                 {"unit", info.unit},
                 {"description", info.doc}};
  std::visit([&](const auto* field) { schema["default"] = *field; }, param.field);
  if (std::isfinite(info.min)) schema["minimum"] = info.min;
  if (std::isfinite(info.max)) schema["maximum"] = info.max;
  if (!info.choices.empty()) schema["enum"] = info.choices;
  schema["stage"] = stage_name(info.stage);
  schema["x-advanced"] = info.advanced;
  return schema;
}

}  // namespace

const ParamRef* ParamList::find(std::string_view key) const {
  for (const ParamRef& param : params_)
    if (param.info.key == key) return &param;
  return nullptr;
}

std::string_view ParamList::nearest_key(std::string_view key) const {
  std::string_view best;
  std::size_t best_distance = static_cast<std::size_t>(-1);
  for (const ParamRef& param : params_) {
    // A right name in the wrong group is nearer than any misspelling.
    const std::size_t distance = std::min(edit_distance(key, param.info.key),
                                          edit_distance(last_part(key), last_part(param.info.key)));
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = param.info.key;
  }
  return best;
}

std::string to_json(const ParamList& list) {
  Json json = Json::object();
  for (const ParamRef& param : list.params())
    std::visit([&](const auto* field) { nested(json, param.info.key) = *field; }, param.field);
  return dump(json, 2) + "\n";
}

void from_json(const ParamList& list, std::string_view text, std::string_view file_name) {
  const std::string where = file_name.empty() ? "" : std::string(file_name) + ": ";
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object())
    fail(Stage::mesh, "params.bad_json", where + "this is not a JSON object",
         "compare it with the job.json that every run writes");
  std::vector<Assignment> assignments;
  collect(list, json, "", where, assignments);
  for (const Assignment& assignment : assignments)
    assign(assignment.param->field, assignment.value);
}

void set_by_key(const ParamList& list, std::string_view key, std::string_view text) {
  const ParamRef& param = find_or_fail(list, std::string(key), "");
  const std::string given(text);
  assign(param.field,
         checked_assignment(param, typed_value(param.field, given), "\"" + given + "\"", "").value);
}

std::string json_schema(const ParamList& list) {
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                 {"title", "Parameters of s3slice"},
                 {"type", "object"},
                 {"additionalProperties", false}};
  for (const ParamRef& param : list.params())
    nested(schema, param.info.key, "properties") = schema_of(param);
  return dump(schema, 2) + "\n";
}

std::vector<std::size_t> diff(const ParamList& a, const ParamList& b) {
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < a.params().size(); ++i)
    if (current_value(a.params()[i]) != current_value(b.params()[i])) positions.push_back(i);
  return positions;
}

void check_ranges(const ParamList& list) {
  for (const ParamRef& param : list.params()) check_range(param.info, current_value(param));
}

}  // namespace s3
