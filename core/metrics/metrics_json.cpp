#include "metrics/metrics_json.h"

#include <nlohmann/json.hpp>

namespace s3 {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace

Json to_json(const Metrics& m) {
  Json json;
  json["support_free_area_percent"] = or_null(m.support_free_area_percent);
  json["support_free_mean_violation_deg"] = or_null(m.support_free_mean_violation_deg);
  json["surface_quality_area_percent"] = or_null(m.surface_quality_area_percent);
  json["surface_quality_region_percent"] = or_null(m.surface_quality_region_percent);
  json["strength_critical_percent"] = or_null(m.strength_critical_percent);
  json["pi_rad"] = or_null(m.pi_rad);
  json["foldovers"] = or_null(m.foldovers);
  json["gouging_pairs"] = or_null(m.gouging_pairs);
  json["concave_pairs_over_20deg"] = or_null(m.concave_pairs_over_20deg);
  json["islands"] = or_null(m.islands);
  json["layers"] = or_null(m.layers);
  json["components"] = or_null(m.components);
  json["thickness_mm"] = nullptr;
  if (const auto& t = m.thickness_mm)
    json["thickness_mm"] = {
        {"min", t->min}, {"p1", t->p1}, {"p50", t->p50}, {"p99", t->p99}, {"max", t->max}};
  json["thickness_outside_area_percent"] = or_null(m.thickness_outside_area_percent);
  json["path_length_mm"] = or_null(m.path_length_mm);
  json["coverage_percent"] = or_null(m.coverage_percent);
  json["overlap_percent"] = or_null(m.overlap_percent);
  json["stress_deviation_deg"] = nullptr;
  if (const auto& d = m.stress_deviation_deg)
    json["stress_deviation_deg"] = {{"p50", d->p50}, {"p90", d->p90}, {"p99", d->p99}};
  json["line_spacing"] = nullptr;
  if (const auto& d = m.line_spacing)
    json["line_spacing"] = {{"p5", d->p5},
                            {"p50", d->p50},
                            {"p95", d->p95},
                            {"within_15_percent", d->within_15_percent}};
  json["surface_error_mm"] = {{"avg", or_null(m.surface_error_avg_mm)},
                              {"max", or_null(m.surface_error_max_mm)}};
  json["strain"] = {{"max", nullptr}, {"p999", nullptr}, {"mean", nullptr}};
  if (const auto& s = m.strain)
    json["strain"] = {{"max", s->max}, {"p999", s->p999}, {"mean", s->mean}};
  json["support_volume_mm3"] = or_null(m.support_volume_mm3);
  json["material_g"] = or_null(m.material_g);
  json["print_time_s"] = or_null(m.print_time_s);
  return json;
}

}  // namespace s3
