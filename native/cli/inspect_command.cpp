#include <cstdio>

#include <nlohmann/json.hpp>

#include "commands.h"
#include "files.h"
#include "pipeline/inspect.h"

namespace s3::cli {
namespace {

using Json = nlohmann::ordered_json;

void print_orientations(const Json& orientations) {
  std::printf("%-22s overhang mm2  support mm3  contact mm2  height mm  stable\n", "input.rotate");
  for (const Json& o : orientations) {
    const auto number = [&](const char* key) { return o[key].get<double>(); };
    std::printf("  %-20s %12.1f %12.1f %12.1f %10.2f  %s\n", o["rotate"].get<std::string>().c_str(),
                number("overhang_area_mm2"), number("support_volume_mm3"),
                number("contact_area_mm2"), number("height_mm"),
                o["stable"].get<bool>() ? "yes" : "no");
  }
}

void print_text(const Json& json) {
  for (const auto& [key, value] : json.items()) {
    if (key == "shells") {
      std::printf("%-22s %zu\n", key.c_str(), value.size());
    } else if (key == "orientations") {
      print_orientations(value);
    } else if (value.is_object() && value.contains("count")) {
      std::printf("%-22s %s", key.c_str(), value["count"].dump().c_str());
      if (!value["where"].empty()) std::printf("  first at %s", value["where"][0].dump().c_str());
      std::printf("\n");
    } else if (value.is_array() && (value.empty() || value[0].is_string())) {
      std::printf("%-22s %s\n", key.c_str(), value.empty() ? "none" : "");
      for (const auto& sentence : value) std::printf("  %s\n", sentence.get<std::string>().c_str());
    } else if (key == "repairs") {
      std::printf("%s\n", key.c_str());
      for (const auto& change : value) {
        std::printf("  %s", change["sentence"].get<std::string>().c_str());
        if (!change["where"].empty())
          std::printf(", first at %s", change["where"][0].dump().c_str());
        std::printf("\n");
      }
    } else {
      std::printf("%-22s %s\n", key.c_str(),
                  value.is_string() ? value.get<std::string>().c_str() : value.dump().c_str());
    }
  }
}

}  // namespace

int inspect_command(const std::string& model, bool as_json) {
  InterruptibleContext interruptible(1);
  const Json json = inspect_model(read_file(model), model, interruptible.context);
  if (as_json) {
    std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  } else {
    print_text(json);
  }
  return kDone;
}

}  // namespace s3::cli
